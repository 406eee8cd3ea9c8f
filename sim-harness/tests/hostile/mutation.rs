//! Bytes that are almost those that are known.

use amiro_ipf::random::{Generator, uniform_below};

/// Values at which arithmetic changes its mind.
const BORDERS: [u8; 8] = [0, 1, 0x1b, 0x7f, 0x80, 0xa5, 0xfe, 0xff];

/// Longest bytes that are made.
const MOST: usize = 4_096;

/// One of the known, changed in one to eight places.
pub(crate) fn mutate(known: &[Vec<u8>], generator: &mut Generator) -> Vec<u8> {
    let mut bytes = known[below(generator, known.len())].clone();
    for _ in 0..1 + below(generator, 8) {
        change(&mut bytes, known, generator);
    }
    bytes.truncate(MOST);
    bytes
}

fn change(bytes: &mut Vec<u8>, known: &[Vec<u8>], generator: &mut Generator) {
    if bytes.is_empty() {
        bytes.push(generator.bits() as u8);
        return;
    }
    let place = below(generator, bytes.len());
    let end = (place + 1 + below(generator, 16)).min(bytes.len());
    match below(generator, 8) {
        0 => bytes[place] ^= 1 << below(generator, 8),
        1 => bytes[place] = generator.bits() as u8,
        2 => bytes[place] = BORDERS[below(generator, BORDERS.len())],
        3 => bytes.insert(place, generator.bits() as u8),
        4 => drop(bytes.drain(place..end)),
        5 => {
            let again = bytes[place..end].to_vec();
            bytes.splice(place..place, again);
        }
        6 => {
            let other = &known[below(generator, known.len())];
            let from = below(generator, other.len().max(1));
            bytes.truncate(place);
            bytes.extend_from_slice(other.get(from..).unwrap_or_default());
        }
        _ => bytes.truncate(place),
    }
}

fn below(generator: &mut Generator, bound: usize) -> usize {
    uniform_below(generator, bound as u32) as usize
}
