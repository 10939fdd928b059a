//! Hostile text inside every language that is written.

use mpcgear::escape::{cell, code, comment, markdown, markup, python, scad, terminal};

/// Texts that broke, or could break, a file of some language.
fn hostile() -> Vec<String> {
    let mut texts: Vec<String> = [
        "*/ echo(1); /*",
        "*/",
        "/*",
        "//",
        "*",
        "**/",
        "* /",
        "/**/",
        "#",
        "# x",
        "\"",
        "'",
        "\"\"\"",
        "'''",
        "\\",
        "\\\\",
        "a\\",
        "\\\"",
        "\\'",
        "\\n",
        "\\x41",
        "\\u0041",
        "\\N{DASH}",
        "\"; echo(1); //",
        "\"); import os #",
        "'; import os #",
        "{{ 7 * 7 }}",
        "{% raw %}",
        "{# x #}",
        "${x}",
        "$(x)",
        "`x`",
        "``",
        "=1+1",
        "+1",
        "-1",
        "-x",
        "@SUM(A1)",
        "\t=1",
        " =1+1",
        "=cmd|' /C calc'!A0",
        "a,b",
        "a;b",
        "a\nb",
        "a\rb",
        "a\r\nb",
        "\n",
        "\n\n\n",
        "]]>",
        "<![CDATA[",
        "</script>",
        "<script>alert(1)</script>",
        "<!--",
        "-->",
        "&amp;",
        "&",
        "&#0;",
        "<",
        ">",
        "|",
        "a|b",
        "[x](javascript:1)",
        "![x](y)",
        "<b>",
        "# h",
        "~~x~~",
        "*x*",
        "[1:2:3]",
        "]",
        "[Hidden]",
        "",
        " ",
        "\t",
        "é",
        "汉字",
        "😀",
        "\u{202e}abc",
        "\u{2066}x",
        "\u{200f}",
        "\u{feff}",
        "\u{ffff}",
        "\u{fffe}",
        "\u{2028}",
        "\u{2029}",
        "\u{85}",
        "\u{0}",
        "a\u{0}b",
        "\u{1b}[31mred",
        "\u{1b}]0;t\u{7}",
        "\u{9b}31m",
        "\u{7f}",
        "\u{8}\u{8}",
        "\u{b}",
        "\u{c}",
        "../victim",
        "%s%n",
        "$x^2$",
    ]
    .map(String::from)
    .into();
    texts.push("a".repeat(300));
    texts.push("\"".repeat(300));
    texts.push("\\".repeat(301));
    texts
}

/// What may stand in no line: it ends one somewhere, or commands a terminal.
fn plain(text: &str) -> bool {
    !text.contains(|c: char| {
        c.is_control() || "\u{2028}\u{2029}\u{202e}\u{2066}\u{ffff}".contains(c)
    })
}

/// The words of a text, which an escaped line keeps.
fn words(text: &str) -> String {
    let gap = |c: char| {
        c.is_whitespace()
            || c.is_control()
            || "\u{2028}\u{2029}\u{202e}\u{2066}\u{200f}\u{fffe}\u{ffff}".contains(c)
    };
    text.split(gap)
        .filter(|w| !w.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// Reads the inside of a quoted string back; `None` where a quote ends it.
fn unquoted(text: &str, quotes: &str) -> Option<String> {
    let mut letters = text.chars();
    let mut out = String::new();
    while let Some(c) = letters.next() {
        match c {
            '\\' => out.push(letters.next()?),
            c if quotes.contains(c) => return None,
            c => out.push(c),
        }
    }
    Some(out)
}

#[test]
fn comments_neither_end_nor_begin_and_keep_to_their_line() {
    for text in hostile() {
        let made = comment(&text);
        assert!(plain(&made), "{text:?}: {made:?}");
        for mark in ["*/", "/*", "[", "]", "\\"] {
            assert!(!made.contains(mark), "{text:?}: {made:?}");
        }
    }
}

#[test]
fn strings_of_scripts_read_back_as_their_words() {
    for text in hostile() {
        assert_eq!(unquoted(&scad(&text), "\""), Some(words(&text)), "{text:?}");
        assert_eq!(
            unquoted(&python(&text), "\"'"),
            Some(words(&text)),
            "{text:?}"
        );
        assert!(plain(&scad(&text)) && plain(&python(&text)), "{text:?}");
    }
}

#[test]
fn markup_holds_no_tag_and_no_end_of_an_attribute() {
    for text in hostile() {
        let made = markup(&text);
        assert!(
            !made.contains(['<', '>', '"', '\'', '\0', '\u{1b}', '\u{ffff}']),
            "{text:?}: {made:?}"
        );
        let back = ["&lt;<", "&gt;>", "&quot;\"", "&#39;'"]
            .iter()
            .map(|pair| pair.split_at(pair.len() - 1))
            .fold(made, |text, (from, to)| text.replace(from, to))
            .replace("&amp;", "&");
        let kept = |c: char| {
            if matches!(c, '\n' | '\t')
                || !(c.is_control() || ('\u{fffe}'..='\u{ffff}').contains(&c))
            {
                c
            } else {
                '\u{fffd}'
            }
        };
        assert_eq!(back, text.chars().map(kept).collect::<String>());
    }
}

#[test]
fn cells_are_no_formulas_and_no_new_columns() {
    for text in hostile() {
        let made = cell(&text);
        let formula = made.trim_start().starts_with(['=', '+', '-', '@']);
        assert!(
            !formula || made.parse::<f64>().is_ok(),
            "{text:?}: {made:?}"
        );
        assert!(made.ends_with(&text));
        let made = markdown(&text);
        let bars = made.replace("\\\\", "").replace("\\|", "");
        assert!(
            plain(&made) && !bars.contains('|') && !made.contains('<'),
            "{text:?}: {made:?}"
        );
        assert!(!code(&text).contains(['`', '|', '\n', '\r']), "{text:?}");
    }
}

#[test]
fn terminals_get_no_commands_and_json_stays_what_it_was() {
    for text in hostile() {
        let made = terminal(&text);
        assert!(plain(&made.replace(['\n', '\t'], "")), "{text:?}: {made:?}");
        let json = serde_json::to_string(&text).expect("json");
        assert_eq!(
            serde_json::from_str::<String>(&terminal(&json)).expect("json"),
            text
        );
    }
}

/// Runs a program that the test setup installs and returns what it prints.
fn printed(program: &str, arguments: &[&str], folder: &std::path::Path) -> String {
    let output = std::process::Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap_or_else(|e| panic!("{program}: {e}; .ci/setup --tests installs it"));
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program}: {told}");
    assert!(
        !told.contains("WARNING") && !told.contains("ERROR"),
        "{told}"
    );
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn python_reads_every_text_as_one_string() {
    let place = tempfile::tempdir().expect("a folder");
    let mut script = "import json\ntexts = []\n".to_string();
    for text in hostile() {
        let (note, text) = (comment(&text), python(&text));
        script += &format!("# {note}\ntexts.append(\"{text}\")\ntexts.append('{text}')\n");
    }
    script += "print(json.dumps(texts))\n";
    std::fs::write(place.path().join("texts.py"), script).expect("written");
    let read: Vec<String> =
        serde_json::from_str(&printed("python3", &["texts.py"], place.path())).expect("a list");
    let twice = |text: &String| [words(text), words(text)];
    assert_eq!(read, hostile().iter().flat_map(twice).collect::<Vec<_>>());
}

#[test]
fn openscad_runs_none_of_the_texts() {
    let place = tempfile::tempdir().expect("a folder");
    let mut script = String::new();
    for (i, text) in hostile().iter().enumerate() {
        let (note, text) = (comment(text), scad(text));
        script += &format!("/* [{note}] */\n// {note}\ntext_{i} = \"{text}\"; // {note}\n");
        script += &format!("echo({i}, len(text_{i}));\n");
    }
    std::fs::write(place.path().join("texts.scad"), script).expect("written");
    printed(
        "openscad",
        &["-o", "texts.echo", "texts.scad"],
        place.path(),
    );
    let echoed = std::fs::read_to_string(place.path().join("texts.echo")).expect("echoed");
    let texts = hostile();
    let expected = texts.iter().enumerate();
    let expected = expected.map(|(i, text)| format!("ECHO: {i}, {}", words(text).chars().count()));
    assert_eq!(
        echoed.lines().collect::<Vec<_>>(),
        expected.collect::<Vec<_>>()
    );
}
