//! `mpcgear size`: the smallest gear that carries a payload.

use mpcgear::Result;
use mpcgear::motion::MotionFile;
use mpcgear::sizing::{self, Demand, Tried};

use super::{json, print_out, say};
use crate::cli::{Cli, SizeArgs};
use crate::terminal::Watch;

/// Prints the sizes that were tried and the command that designs the smallest one; exit code 0, 3 where
/// none carries it, 130 when stopped.
///
/// # Errors
/// Bad input; as [`sizing::smallest`].
pub fn run(cli: &Cli, args: &SizeArgs) -> Result<u8> {
    let (mut file, motion) = MotionFile::read_changed(&args.file, &args.set)?;
    let motion = motion?;
    if let Some(material) = args.material {
        file.settings.load.driver_material = material;
        file.settings.load.follower_material = material;
    }
    let demand = Demand {
        payload_g: args.payload,
        deflection_mm: args.max_deflection,
    };
    let watch = Watch::new(cli.quiet || cli.json);
    let sizing = sizing::smallest(&file, &motion, demand, &mut |progress| watch.tell(progress));
    watch.finish();
    let sizing = sizing?;
    if cli.json {
        print_out(&json(&sizing)?)?;
    }
    say(cli, "    L mm   hold  payload g  deflection mm  limited by")?;
    for tried in &sizing.tried {
        say(cli, &row(tried))?;
    }
    say(cli, "")?;
    if sizing.stopped {
        say(cli, "stopped; nothing is proved yet")?;
        return Ok(130);
    }
    let Some(size) = sizing.center_distance_mm else {
        say(cli, "no size that was tried carries it")?;
        return Ok(3);
    };
    let mut changes = vec![
        format!("gear.center_distance_mm={size}"),
        format!("load.mass_g={}", args.payload),
        format!("load.payload_at_least_g={}", args.payload),
    ];
    if let Some(material) = args.material {
        for gear in ["driver", "follower"] {
            changes.push(format!("load.{gear}_material='\"{material}\"'"));
        }
    }
    changes.extend(args.set.iter().map(|change| format!("'{change}'")));
    let changes: Vec<String> = changes.iter().map(|c| format!(" --set {c}")).collect();
    say(
        cli,
        &format!("L = {size} mm carries it, proved on its meshes; next:"),
    )?;
    let path = args.file.display();
    say(
        cli,
        &format!("mpcgear design {path}{} -o out", changes.concat()),
    )
}

fn row(tried: &Tried) -> String {
    let number =
        |x: Option<f64>, digits: usize| x.map_or("–".into(), |x| format!("{x:.digits$}"));
    let remark = match (&tried.problems, tried.payload_limit, tried.hold) {
        (Some(problems), ..) if !problems.is_empty() => format!("proof: {}", problems[0]),
        (_, _, None) => "no gear of this size was found".into(),
        (_, Some(limit), _) => limit.to_string(),
        (_, None, _) => "nothing: weight does not load the contacts".into(),
    };
    format!(
        "{:8.1} {:>6} {:>10} {:>14}  {}{remark}",
        tried.center_distance_mm,
        number(tried.hold, 2),
        number(tried.payload_g, 0),
        number(tried.deflection_mm, 3),
        if tried.is_enough { "enough; " } else { "" },
    )
}
