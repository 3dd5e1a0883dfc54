//! The page of a run as readers see it: in a browser at two widths, with units and limits, and with meshes seen from one side.
#![cfg(feature = "bundled")]

mod common;

use std::process::Command;

use common::{Project, animals::gallop, cube, json};
use mimesh::core::testkit::data::missing;
use serde_json::Value;

/// A browser without a display, or a visible skip; with CI=true its absence is a failure.
fn browser() -> Option<&'static str> {
    let found = ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success()));
    if found.is_none() {
        missing("chromium", "install it with the package manager of your system");
    }
    found
}

/// Opens `out/report.html` in a frame of a width in pixels, with all details open, and gives what is found there.
///
/// A word is broken if its letters stand on several lines.
fn measure(browser: &str, project: &Project, width: u32) -> Value {
    let page = r#"<!DOCTYPE html><title>frame</title><link rel="icon" href="data:,">
<iframe id="page" src="report.html" width="WIDTH" height="800" style="border:0"></iframe><p id="found">waiting</p>
<script>
document.getElementById('page').onload = (event) => {
  const page = event.target.contentDocument;
  for (const details of page.querySelectorAll('details')) details.open = true;
  const texts = page.createTreeWalker(page.body, NodeFilter.SHOW_TEXT);
  const words = [];
  let count = 0;
  while (texts.nextNode()) {
    const node = texts.currentNode;
    for (const word of node.data.matchAll(/[\p{L}\p{N}]+(?:[.,]\d+)*/gu)) {
      const range = page.createRange();
      range.setStart(node, word.index);
      range.setEnd(node, word.index + word[0].length);
      count += 1;
      const lines = new Set([...range.getClientRects()].map((box) => Math.round(box.top / 4)));
      if (lines.size > 1) words.push(word[0]);
    }
  }
  const images = [...page.images];
  document.getElementById('found').textContent = JSON.stringify({
    wide: page.documentElement.scrollWidth, count, words, images: images.length, curves: page.querySelectorAll('svg').length,
    failed: images.filter((image) => !image.complete || image.naturalWidth === 0).length,
  });
};
</script>"#;
    project.write("out/frame.html", &page.replace("WIDTH", &width.to_string()));
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files"])
        .args(["--enable-logging=stderr", "--virtual-time-budget=10000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", project.path("out/frame.html").display()))
        .output()
        .unwrap();
    let (dom, log) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let complaints: Vec<_> = log.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(complaints.is_empty(), "{complaints:?}");
    let found = dom.split("id=\"found\">").nth(1).and_then(|rest| rest.split('<').next()).unwrap_or_default();
    json(found)
}

/// Neither a word is broken nor does a reader have to push the page about, on a screen and on a phone.
fn check_in_browser(browser: &str, project: &Project) {
    for width in [1200, 390] {
        let found = measure(browser, project, width);
        assert_eq!(found["failed"], 0, "{found}");
        assert!(found["count"].as_u64() > Some(100), "{found}");
        assert_eq!(found["words"], json("[]"), "words broken at {width} pixels");
        assert!(found["wide"].as_u64() <= Some(u64::from(width)), "{width}: {found}");
    }
}

/// The part of the page from the heading that begins with `heading` to the end of its section.
fn section<'p>(page: &'p str, heading: &str) -> &'p str {
    let rest = page.split(&format!("<h2>{heading}")).nth(1).unwrap_or_else(|| panic!("no section {heading}"));
    rest.split("</section>").next().unwrap()
}

/// The data of the picture whose text begins with `alt`.
fn picture<'p>(page: &'p str, alt: &str) -> &'p str {
    let found = page.split("<img src=\"").skip(1).find(|image| image.contains(&format!("alt=\"{alt}")));
    found.unwrap_or_else(|| panic!("no picture {alt}")).split('"').next().unwrap()
}

#[test]
fn a_browser_shows_the_page_without_a_complaint_on_a_phone_too() {
    let Some(browser) = browser() else { return };
    let project = Project::new();
    gallop(&project, "gates: { point_error_p95: 0.001 }");
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q"]).status, 3);
    check_in_browser(browser, &project);
    let found = measure(browser, &project, 390);
    assert!(found["images"].as_u64() >= Some(8) && found["curves"].as_u64() >= Some(2), "{found}");
}

#[test]
fn long_names_of_poses_and_files_break_at_their_separators_or_not_at_all() {
    let Some(browser) = browser() else { return };
    let project = Project::new();
    let names = [
        "left_front_leg_raised_and_right_hind_leg_stretched_backwards_0001",
        "ajawthatopensaswideasitcanwithoutanyseparatorinitswholelongname",
        "Brow.Inner-Up.And-Cheek.Squint-Left.With-Tongue.Out",
    ];
    for (k, name) in names.iter().enumerate() {
        project.write(&format!("pose-{name}.obj"), &common::leaning(0.1 * (k + 1) as f64));
    }
    project.edit("output: out/{pose}.obj", "gates: { volume: 0.0001 }\noutput: [\"out/{pose}.obj\", out/report.html]");
    project.mimesh(&["run", "p.yaml", "-q"]);
    let page = project.read("out/report.html");
    assert!(page.contains("left_<wbr>front_<wbr>leg"), "a name that may break");
    assert!(page.contains(&format!("title=\"{}\"", names[1])), "a name that is cut off has a title");
    check_in_browser(browser, &project);
}

#[test]
fn statistics_have_units_and_limits_and_the_verdict_ends_with_a_next_step() {
    let project = Project::new();
    gallop(&project, "gates: { point_error_p95: 0.001 }");
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q"]).status, 3);
    let page = project.read("out/report.html");
    let table = section(&page, "Verdict of each pose");
    assert!(table.contains("<small>mean, %</small>") && table.contains("<small>p95, %</small>"), "{table}");
    for row in ["doubtful above", "bad above", "gate"] {
        assert!(table.contains(&format!("<th>{row}</th>")), "{row}: {table}");
    }
    assert!(section(&page, "Look at these").contains("\u{a0}%, above 0.001\u{a0}%"));
    let averages = section(&page, "Metrics over all poses");
    assert!(
        averages.contains("bad above") && averages.contains("\u{a0}%") && averages.contains("doing nothing"),
        "{averages}"
    );
    let steps = section(&page, "What to do next");
    assert!(
        steps.contains("The gate of point error p95 is 0.001\u{a0}%") && steps.contains("mimesh compare"),
        "{steps}"
    );

    // Where all is well there is a step too.
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q", "--set", "gates.point_error_p95=50"]).status, 0);
    assert!(section(&project.read("out/report.html"), "What to do next").contains("<li>"));
}

#[test]
fn a_fault_that_all_poses_share_is_told_once() {
    let project = Project::new();
    project.write("target.obj", &cube(|[x, y, z]| [-x, y, z]));
    project.edit("output: out/{pose}.obj", "output: [\"out/{pose}.obj\", out/report.html]");
    project.mimesh(&["run", "p.yaml", "-q"]);
    let report = json(&project.read("out/run.json"));
    assert!(report["poses"].as_array().is_some_and(|poses| poses.len() > 1));
    assert_eq!(report["rest_verdict"]["reasons"][0]["metric"], "marker_fit", "{}", report["rest_verdict"]);
    let page = project.read("out/report.html");
    let of_map = section(&page, "Map and markers");
    assert_eq!(page.matches("<li>left and right are swapped<").count(), 1, "the reason: {of_map}");
    assert_eq!(page.matches("lies far from where the others expect it").count(), 1, "what is wrong");
    assert!(of_map.contains("<li>left and right are swapped<"));
    let steps = section(&page, "What to do next");
    assert!(steps.contains("Look at the numbered markers"), "{steps}");
}

#[test]
fn a_target_that_is_turned_is_seen_from_the_same_side() {
    let markers = (0..8).map(|k| format!("{k}, {k}\n")).collect::<String>();
    for has_markers in [false, true] {
        let drawn = |place: fn([f64; 3]) -> [f64; 3], more: &str| {
            let project = Project::new();
            project.write("target.obj", &cube(place));
            let markers = if has_markers {
                project.write("m.cons", &format!("8\n{markers}"));
                "markers: m.cons\n"
            } else {
                ""
            };
            // From the side all coordinates of the camera are exact.
            let settings = format!("{markers}pictures: {{ view: side{more} }}\noutput: [out/report.html]");
            project.edit("output: out/{pose}.obj", &settings);
            let output = project.mimesh(&["run", "p.yaml", "-q"]);
            assert!([0, 3].contains(&output.status), "{}", output.stderr);
            picture(&project.read("out/report.html"), "the target at rest, with").to_owned()
        };
        let plain = drawn(|p| p, "");
        assert!(plain == drawn(|[x, y, z]| [x, -z, y], ""), "Z up");
        assert!(plain == drawn(|[x, y, z]| [-x, y, -z], ""), "from behind");
        assert!(plain == drawn(|[x, y, z]| [z, x, y], ""), "X and Z exchanged with Y");
        assert!(plain != drawn(|[x, y, z]| [x, -z, y], ", target_up: y"), "what the pipeline says comes first");
    }
}
