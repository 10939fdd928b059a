//! The report as a browser shows it.
#![allow(clippy::unwrap_used)] // in helpers too a failed step is a failed test

mod known;
mod synthetic;

use std::path::PathBuf;

use mpcgear::design::Design;
use mpcgear::export::Source;
use mpcgear::export::compare;
use mpcgear::export::evidence::{Evidence, Verdicts};
use mpcgear::export::report::{self, Claim, ReportInput};
use mpcgear::load::Load;
use mpcgear::motion::{Class, Motion};
use mpcgear::solid::Solids;
use mpcgear::stats::{self, Format};

fn scratch(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn design(class: Class) -> Design {
    let (mut design, _) = synthetic::uniform(class);
    design.name = format!("uniform {class}");
    design.closure = known::closure_of(&design);
    design
}

fn revolute() -> Design {
    design(Class::R1)
}

fn spherical() -> Design {
    design(Class::R3)
}

/// The report's input with everything in it, handed to `use_it`.
fn with_input<T>(mut design: Design, use_it: impl FnOnce(&ReportInput) -> T) -> T {
    design.settings.load = Load {
        mass_g: 200.0,
        point_mm: [18.0, 0.0, 58.0],
        gravity: [0.2, 0.0, -1.0],
        ..Load::default()
    };
    let motion = Motion::new(design.class, &design.motion).unwrap();
    let solids = Solids::build(&design, &motion).unwrap();
    design.recipe = solids.recipe.clone();
    let claim = |name: &str, meaning: &str, figure: &str| Claim {
        name: name.into(),
        meaning: meaning.into(),
        figure: figure.into(),
        limit: "0".into(),
        place: "φ = 12.0°".into(),
        holds: true,
        ..Claim::default()
    };
    let source = Source {
        design: &design,
        motion: &motion,
        solids: Some(&solids),
    };
    let claims = vec![
        claim("no overlap", "No two parts ever share space.", "0 mm³"),
        claim(
            "no escape",
            "The follower cannot be moved with the motor held.",
            "0 of 2304",
        ),
    ];
    let verdicts = Verdicts { claims, load: None };
    let files = ["print/driver.stl", "parts.md"].map(PathBuf::from);
    let evidence = Evidence::gather(&source, verdicts, &files).unwrap();
    use_it(&evidence.input(&source, "name = \"<b>bold</b> </script>\"\n"))
}

#[test]
fn the_report_is_one_small_file_without_links_to_the_network() {
    let text = with_input(revolute(), report::html).unwrap();
    assert!(text.len() < 10_000_000, "{} bytes", text.len());
    for link in ["src=\"http", "href=\"http", "url(http", "@import", "fetch("] {
        assert!(!text.contains(link), "{link}");
    }
    assert!(
        text.contains("&lt;b&gt;bold") && !text.contains("<b>bold"),
        "the user's text is escaped"
    );
}

/// What the page reports about itself when a browser has run it.
#[derive(serde::Deserialize)]
struct Seen {
    errors: Vec<String>,
    colors: usize,
    plots: Vec<String>,
    poses: Vec<(f64, Vec<f64>)>,
    angle: String,
    q_min: f64,
    moved: bool,
    keyboard: String,
}

/// Added to the page: collects errors from the start and, when all is drawn, tells what is there.
const WATCH: &str = "<script>window.seenErrors = [];
  addEventListener('error', (e) => seenErrors.push(e.message));
  addEventListener('securitypolicyviolation', (e) => seenErrors.push(e.effectiveDirective + ' blocks ' + e.blockedURI));
  addEventListener('unhandledrejection', (e) => seenErrors.push(String(e.reason)));
  for (const level of ['error', 'warn']) console[level] = (...a) => seenErrors.push(a.join(' '));</script>";
const PROBE: &str = "<script>setTimeout(() => {
  const shot = () => {
    mpcgear.state.dirty = true; mpcgear.view.draw();
    const from = document.getElementById('canvas'), to = document.createElement('canvas');
    to.width = from.width; to.height = from.height;
    const context = to.getContext('2d');
    context.drawImage(from, 0, 0);
    return context.getImageData(0, 0, to.width, to.height).data;
  };
  const slider = document.getElementById('phi'), poses = [];
  const first = shot();
  for (const phi of [0, 36.5, 90, 213, 360]) {
    slider.value = phi;
    slider.dispatchEvent(new Event('input'));
    poses.push([phi, mpcgear.followerMatrix()]);
  }
  slider.value = 100;
  slider.dispatchEvent(new Event('input'));
  const second = shot(), colors = new Set();
  for (let i = 0; i < second.length; i += 4) if (second[i + 3] > 200) colors.add((second[i] >> 4) * 256 + (second[i + 1] >> 4) * 16 + (second[i + 2] >> 4));
  const angle = document.getElementById('angle').value;
  document.body.dispatchEvent(new KeyboardEvent('keydown', { key: '.', bubbles: true }));
  const q = charts.all.find((c) => c.plot.id === 'q');
  const result = { errors: seenErrors, colors: colors.size, plots: charts.all.map((c) => c.plot.id), poses, angle,
    q_min: Math.min(...q.u.data[1]), moved: first.some((v, i) => v !== second[i]), keyboard: document.getElementById('angle').value };
  const out = document.createElement('pre');
  out.id = 'seen';
  out.textContent = '<<' + JSON.stringify(result) + '>>';
  document.body.append(out);
}, 500);</script>";

/// A script that got into the page somehow.
const INTRUDER: &str = "<script>document.body.textContent = '';</script>";

/// [`PROBE`] as the page's policy knows it.
fn probe_hash() -> String {
    use base64::{Engine, engine::general_purpose::STANDARD};
    use sha2::{Digest, Sha256};
    let text = PROBE
        .strip_prefix("<script>")
        .and_then(|t| t.strip_suffix("</script>"));
    STANDARD.encode(Sha256::digest(text.expect("a script")))
}

/// Runs Debian's Chromium without a display on `html` and returns what [`PROBE`] saw.
fn in_browser(html: &str, name: &str) -> Seen {
    let page = scratch(name);
    let probed = html
        .replacen("<head>", &format!("<head>{WATCH}"), 1)
        .replacen("</body>", &format!("{INTRUDER}{PROBE}</body>"), 1)
        .replacen(
            "script-src ",
            &format!("script-src 'sha256-{}' ", probe_hash()),
            1,
        );
    std::fs::write(&page, probed).unwrap();
    let profile = tempfile::tempdir().unwrap();
    let output = std::process::Command::new("chromium")
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu-sandbox",
            "--use-gl=angle",
            "--use-angle=swiftshader",
        ])
        .args([
            "--enable-unsafe-swiftshader",
            "--window-size=1366,768",
            "--virtual-time-budget=20000",
            "--dump-dom",
        ])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("chromium runs (Debian: apt-get install chromium)");
    let dom = String::from_utf8_lossy(&output.stdout);
    let json = dom
        .split("&lt;&lt;")
        .nth(1)
        .and_then(|rest| rest.split("&gt;&gt;").next());
    let json =
        json.unwrap_or_else(|| panic!("no result: {}", String::from_utf8_lossy(&output.stderr)));
    serde_json::from_str(
        &json
            .replace("&amp;", "&")
            .replace("&lt;", "<")
            .replace("&gt;", ">"),
    )
    .unwrap()
}

#[test]
fn a_browser_shows_the_mechanism_moves_it_and_plots_the_figures() {
    let design = spherical();
    let (q_min, motion) = (
        design
            .closure
            .iter()
            .map(|c| c.q)
            .fold(f64::INFINITY, f64::min),
        Motion::new(design.class, &design.motion).unwrap(),
    );
    let html = with_input(design, report::html).unwrap();
    let seen = in_browser(&html, "spherical.html");
    assert_eq!(seen.errors, ["script-src-elem blocks inline"]);
    assert!(
        seen.colors > 30,
        "only {} colours: blank canvas",
        seen.colors
    );
    assert!(seen.moved, "the slider changes the picture");
    assert_eq!(seen.angle, "100.0°");
    assert_eq!(seen.keyboard, "101.0°");
    assert_eq!(
        seen.plots,
        [
            "q",
            "eta",
            "force",
            "torque",
            "pressure",
            "root",
            "play",
            "play_turn"
        ]
    );
    assert!((seen.q_min - q_min).abs() < 1e-12);
    let home = motion.state(0.0).pose;
    for (phi, matrix) in seen.poses {
        // The view moves a body given at φ = 0: M(φ)·M(0)⁻¹.
        let pose = motion.state(phi.to_radians()).pose;
        let rotation = pose.rotation * home.rotation.transpose();
        let translation = pose.translation - rotation * home.translation;
        for row in 0..3 {
            for column in 0..3 {
                assert!(
                    (matrix[4 * row + column] - rotation[(row, column)]).abs() < 1e-5,
                    "φ = {phi}: {matrix:?}"
                );
            }
            assert!(
                (matrix[4 * row + 3] - translation[row]).abs() < 1e-4,
                "φ = {phi}: {matrix:?}"
            );
        }
    }
}

#[test]
fn pictures_need_no_browser_and_are_not_blank() {
    let folder = tempfile::tempdir().unwrap();
    let paths = with_input(spherical(), |input| {
        report::write_pictures(input, folder.path())
    })
    .unwrap();
    let names: Vec<_> = paths
        .iter()
        .map(|p| p.file_stem().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "mechanism",
            "q",
            "eta",
            "force",
            "torque",
            "pressure",
            "root",
            "play",
            "play_turn"
        ]
    );
    for path in &paths {
        let decoder =
            png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let size = info.color_type.samples();
        let colors: std::collections::HashSet<&[u8]> =
            pixels[..info.buffer_size()].chunks(size).collect();
        assert!(
            colors.len() > 20,
            "{}: {} colours",
            path.display(),
            colors.len()
        );
        std::fs::copy(path, scratch(path.file_name().unwrap().to_str().unwrap())).unwrap();
    }
}

#[test]
fn an_unchecked_or_failed_design_does_not_look_like_a_working_one() {
    let mut design = revolute();
    let verdict = |design: Design, claims: bool| {
        with_input(design, |input| {
            let claims = if claims { input.claims } else { &[] };
            report::html(&ReportInput {
                claims,
                ..input.clone()
            })
        })
        .unwrap()
    };
    assert!(verdict(design.clone(), true).contains("<b>Works.</b>"));
    assert!(verdict(design.clone(), false).contains("<b>Not checked.</b>"));
    design.problems = vec!["teeth of pair 1 & 2 collide".into()];
    let draft = verdict(design, true);
    assert!(draft.contains("<b>Draft.</b>") && draft.contains("pair 1 &amp; 2 collide"));
}

fn saved(designs: &[Design]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (i, design) in designs.iter().enumerate() {
        let out = folder.path().join(format!("out{i}"));
        std::fs::create_dir(&out).unwrap();
        std::fs::write(
            out.join("design.json"),
            mpcgear::design::file::text(design).unwrap(),
        )
        .unwrap();
        std::fs::write(
            out.join("summary.json"),
            r#"{"feasible": true, "wall_seconds": 12.34, "k": 2}"#,
        )
        .unwrap();
    }
    folder
}

#[test]
fn statistics_are_one_table_in_three_formats() {
    let folder = saved(&[revolute(), spherical()]);
    let entries = stats::collect(&[folder.path().into()]).unwrap();
    let table = stats::table(&entries);
    let markdown = table.render(Format::Markdown).unwrap();
    assert!(
        markdown.starts_with("| design | class | K |") && markdown.lines().count() == 4,
        "{markdown}"
    );
    let text = table.render(Format::Text).unwrap();
    assert!(
        text.lines().nth(2).unwrap().starts_with("uniform 3R  3R"),
        "{text}"
    );
    let csv = table.render(Format::Csv).unwrap();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.unwrap()).collect();
    assert_eq!(
        (&rows[0][2], &rows[1][2], &rows[1][9], &rows[1][10]),
        ("2", "4", "yes", "12")
    );
    let q = spherical()
        .closure
        .iter()
        .map(|c| c.q)
        .fold(f64::INFINITY, f64::min);
    assert!((rows[1][4].parse::<f64>().unwrap() - q).abs() < 0.01);
    let nothing = stats::collect(&[tempfile::tempdir().unwrap().path().into()]).unwrap_err();
    assert!(nothing.exit_code() == 2, "{nothing}");
}

#[test]
fn designs_are_compared_on_one_page() {
    let folder = saved(&[revolute(), spherical()]);
    let entries = stats::collect(&[folder.path().into()]).unwrap();
    let page = compare::html(&entries).unwrap();
    assert!(
        page.contains("2 designs compared")
            && page.contains("uniform 1R")
            && page.len() < 1_000_000
    );
    std::fs::write(scratch("compare.html"), &page).unwrap();
    let q = &compare::plots(&entries)[0];
    for (series, entry) in q.series.iter().zip(&entries) {
        let shown = series
            .values
            .iter()
            .flatten()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let exact = entry
            .design
            .closure
            .iter()
            .map(|c| c.q)
            .fold(f64::INFINITY, f64::min);
        assert!(
            (shown - exact).abs() < 1e-9,
            "{}: {shown} {exact}",
            series.label
        );
        assert!(series.values.iter().all(Option::is_some));
    }
}

#[test]
fn a_draft_without_solids_or_teeth_still_has_a_report() {
    let mut draft = revolute();
    draft.sub_gear_pairs[1].teeth.truncate(4);
    draft.problems = vec!["no compatible second band".into()];
    let motion = Motion::new(draft.class, &draft.motion).unwrap();
    let source = Source {
        design: &draft,
        motion: &motion,
        solids: None,
    };
    let evidence = Evidence::gather(&source, Verdicts::default(), &[]).unwrap();
    assert!(evidence.load.is_none() && evidence.sensitivity.is_none());
    let html = report::html(&evidence.input(&source, "")).unwrap();
    assert!(html.contains("<b>Draft.</b>") && html.contains("no compatible second band"));
    let seen = in_browser(&html, "draft.html");
    assert_eq!(seen.errors, ["script-src-elem blocks inline"]);
}
