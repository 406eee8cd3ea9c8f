//! The page that shows all figures: plain HTML, no scripts, relative links.

use super::page_section::{PageSection, PageTable, Panel};

/// The head of the page, up to the first figure.
const HEAD: &str = r#"<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Inverse particle filter: the figures</title>
<style>
body { max-width: 1176px; margin: 20px auto; padding: 0 12px; font: 16px/1.45 sans-serif; color: #222; }
h2 { margin-top: 48px; border-top: 1px solid #bbb; padding-top: 16px; }
.row { display: flex; flex-wrap: wrap; gap: 12px; align-items: flex-start; }
figure { margin: 0; }
figure img { max-width: 100%; display: block; }
figcaption { font-size: 14px; color: #555; padding-left: 10px; }
table { border-collapse: collapse; margin: 16px 0; font-size: 14px; }
caption { text-align: left; padding-bottom: 6px; color: #555; }
th, td { padding: 3px 14px 3px 0; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child, th:nth-child(2), td:nth-child(2) { text-align: left; }
</style>
</head>
<body>
<h1>The figures of the inverse particle filter, simulated</h1>
<p>Korthals et al. 2016 show their filter in figures; these are the same figures from
this project's filter. <b>Everything here is simulated</b>: the worlds, the drives, and
the sensors' counts with the noise of the published sensor model. Nothing on this page
was measured on a robot.</p>
<p><b>paper</b> is the filter as the paper describes it, <b>plus</b> is this project's
variant of it, <b>ISM</b> is the inverse sensor model, the usual occupancy grid that the
paper compares itself with; <i>standard</i> and <i>tuned</i> are two settings of its
evidence. In maps, black is occupied, white is free, grey is unknown, red outlines are
what truly stands there, and the blue line is the robot's way.</p>
"#;

/// The page that shows these figures, in their order.
///
/// Pictures are named as in [`Panel::file`] and looked for beside the page.
#[must_use]
pub fn page(sections: &[PageSection]) -> String {
    let mut html = HEAD.to_owned();
    html.push_str("<ul>\n");
    for section in sections {
        let (name, title) = (escaped(section.name), escaped(section.title));
        html.push_str(&format!("<li><a href=\"#{name}\">{title}</a></li>\n"));
    }
    html.push_str("</ul>\n");
    for section in sections {
        show_section(&mut html, section);
    }
    html.push_str("</body>\n</html>\n");
    html
}

fn show_section(html: &mut String, section: &PageSection) {
    let (name, title) = (escaped(section.name), escaped(section.title));
    html.push_str(&format!("<h2 id=\"{name}\">{title}</h2>\n"));
    html.push_str(&format!("<p>{}</p>\n", escaped(section.caption)));
    for row in &section.rows {
        if !row.heading.is_empty() {
            html.push_str(&format!("<h3>{}</h3>\n", escaped(&row.heading)));
        }
        html.push_str("<div class=\"row\">\n");
        for panel in &row.panels {
            show_panel(html, panel);
        }
        html.push_str("</div>\n");
    }
    for table in &section.tables {
        show_table(html, table);
    }
}

fn show_panel(html: &mut String, panel: &Panel) {
    let (width, height) = (panel.picture.width(), panel.picture.height());
    html.push_str(&format!(
        "<figure style=\"max-width: {width}px\"><img src=\"{}\" alt=\"{}\" width=\"{width}\" height=\"{height}\">",
        escaped(&panel.file),
        escaped(&panel.alternative),
    ));
    if !panel.note.is_empty() {
        let note = escaped(&panel.note);
        html.push_str(&format!("<figcaption>{note}</figcaption>"));
    }
    html.push_str("</figure>\n");
}

fn show_table(html: &mut String, table: &PageTable) {
    fn line<S: AsRef<str>>(cells: &[S], tag: &str) -> String {
        let cell = |text: &S| format!("<{tag}>{}</{tag}>", escaped(text.as_ref()));
        let cells: String = cells.iter().map(cell).collect();
        format!("<tr>{cells}</tr>\n")
    }
    let rows: String = table.rows.iter().map(|row| line(row, "td")).collect();
    let head = line(&table.head, "th");
    let caption = escaped(table.caption);
    html.push_str(&format!(
        "<table>\n<caption>{caption}</caption>\n{head}{rows}</table>\n"
    ));
}

/// The text with HTML's own characters written out.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::super::page_section::PanelRow;
    use super::*;
    use crate::report::picture::Picture;

    #[test]
    fn the_page_names_every_picture_and_escapes_every_text() {
        let panel = |part: &str| Panel {
            note: "a < b".to_owned(),
            ..Panel::new(
                "figure",
                part,
                "\"quoted\"".to_owned(),
                Picture::new(7, 5, [0; 3]),
            )
        };
        let table = PageTable {
            caption: "x & y",
            head: vec!["a>b"],
            rows: vec![vec!["<script>".to_owned()]],
        };
        let section = PageSection {
            name: "figure-0",
            title: "A & B",
            caption: "1 < 2",
            rows: vec![PanelRow {
                heading: "<h>".to_owned(),
                panels: vec![panel("one"), panel("two")],
            }],
            tables: vec![table],
            excerpt: None,
        };
        let html = page(&[section]);
        for wanted in [
            "src=\"figure-one.png\"",
            "src=\"figure-two.png\"",
            "width=\"7\" height=\"5\"",
            "alt=\"&quot;quoted&quot;\"",
            "a &lt; b",
            "A &amp; B",
            "1 &lt; 2",
            "&lt;h&gt;",
            "x &amp; y",
            "<th>a&gt;b</th>",
            "<td>&lt;script&gt;</td>",
        ] {
            assert!(html.contains(wanted), "{wanted} is not in {html}");
        }
        assert!(!html.contains("<script"), "{html}");
    }
}
