//! Every placement file that is refused, with line, element and fault.

use super::*;

const KNEE: &str = r#"# The knee alone.
[[actuator]]
name = "knee"
kind = "linear"
actuator = "thor-linear"
spring = "compliant"
link_1 = "thigh"
point_1_m = [-0.05, 0.0, -0.25]
link_2 = "shank"
point_2_m = [-0.06, 0.0, 0.0]
"#;

const HOEKENS: &str = r#"[[actuator]]
name = "knee"
kind = "hoekens"
actuator = "thor-hoekens"
link_1 = "thigh"
link_2 = "shank"
joint = "knee"
crank_angle_at_zero_rad = 1.15
sign = -1
length_mid_m = 0.33
point_1_m = [-0.06, 0.0, -0.07]
axis_1 = [0.0, 0.0, -1.0]
"#;

fn place(text: &str) -> Result<Robot, LegError> {
    Robot::from_urdf(&leg(), "r.urdf", None).expect("a good leg").with_placement(text, "r.toml", None)
}

/// Line 2, where the entry starts.
fn refused(text: &str, element: &str) -> RobotFault {
    let (line, what, fault) = taken_apart(place(text).expect_err("must be refused"));
    assert_eq!((line, what.as_str()), (Some(2), element), "{fault}");
    fault
}

#[test]
fn the_good_ones_are_good() {
    assert_eq!(place(KNEE).expect("good").actuators.len(), 1);
    let robot = place(HOEKENS).expect("good");
    assert_eq!(robot.actuators[0].spec.as_ref().map(|s| s.id.as_str()), Some("thor-hoekens"));
    assert!(place("").expect("no actuator").actuators.is_empty());
}

#[test]
fn unknown_keys_with_a_suggestion() {
    let message = place(&KNEE.replace("point_2_m", "point_2")).expect_err("misspelt").to_string();
    assert!(message.starts_with("r.toml:10:1: "), "{message}");
    assert!(message.contains("did you mean 'point_2_m'?"), "{message}");
    assert!(place("[[aktuator]]\nname = \"a\"").is_err());
    assert!(place("[[actuator]\nname = ").expect_err("no TOML").to_string().starts_with("r.toml:1:"));
}

#[test]
fn unknown_links_and_joints() {
    let fault = refused(&KNEE.replace("\"shank\"", "\"shnak\""), "actuator 'knee' link_2");
    let suggestion = Some("shank".to_owned());
    assert_eq!(fault, RobotFault::UnknownLink { name: "shnak".to_owned(), suggestion });
    let text = format!("\n{}", HOEKENS.replace("joint = \"knee\"", "joint = \"kne\""));
    let fault = refused(&text, "actuator 'knee' joint");
    let suggestion = Some("knee".to_owned());
    assert_eq!(fault, RobotFault::UnknownJoint { name: "kne".to_owned(), suggestion });
}

#[test]
fn points_that_coincide() {
    // The knee is half a metre below the thigh's frame: both points are the same place.
    let text = KNEE.replace("[-0.05, 0.0, -0.25]", "[-0.06, 0.0, -0.5]");
    let fault = refused(&text, "actuator 'knee'");
    assert!(matches!(fault, RobotFault::PointsCoincide { distance_m } if distance_m < 1e-12), "{fault}");
}

#[test]
fn links_with_nothing_between() {
    let text = KNEE.replace("\"shank\"", "\"thigh\"");
    let fault = refused(&text, "actuator 'knee'");
    assert!(matches!(fault, RobotFault::NothingToDrive { .. }), "{fault}");
}

#[test]
fn actuators_and_settings_that_are_not_there() {
    let fault = refused(&KNEE.replace("thor-linear", "thor-liner"), "actuator 'knee' actuator");
    assert!(fault.to_string().contains("did you mean 'thor-linear'?"), "{fault}");
    let fault = refused(&KNEE.replace("\"compliant\"", "\"complient\""), "actuator 'knee' spring");
    assert!(fault.to_string().contains("did you mean 'compliant'?"), "{fault}");
    let fault = refused(&KNEE.replace("thor-linear", "mine.toml"), "actuator 'knee' actuator");
    assert!(fault.to_string().contains("mine.toml"), "{fault}");
}

#[test]
fn drives_that_do_not_fit_their_actuator() {
    let fault = refused(&KNEE.replace("thor-linear", "thor-hoekens"), "actuator 'knee' kind");
    assert!(fault.to_string().contains("hoekens"), "{fault}");
    let text = format!("\n{}", HOEKENS.replace("thor-hoekens", "thor-linear"));
    assert!(refused(&text, "actuator 'knee' actuator").to_string().contains("no linkage"));
    let rotary = refused(&KNEE.replace("thor-linear", "rmd-x8-rotary-sea"), "actuator 'knee' actuator");
    assert!(rotary.to_string().contains("rotary"), "{rotary}");
}

#[test]
fn keys_missing_or_without_meaning() {
    let text = KNEE.replace("point_2_m = [-0.06, 0.0, 0.0]\n", "");
    assert_eq!(refused(&text, "actuator 'knee'"), RobotFault::Missing("'point_2_m'".to_owned()));
    let fault = refused(&format!("{KNEE}joint = \"knee\"\n"), "actuator 'knee' joint");
    assert!(matches!(fault, RobotFault::Invalid(_)), "{fault}");
}

#[test]
fn values_that_cannot_be() {
    for (good, bad, field) in [
        ("[-0.06, 0.0, 0.0]", "[nan, 0.0, 0.0]", "point_2_m"),
        ("[-0.06, 0.0, 0.0]", "[-0.06, 0.0, 0.0]\nlength_m = [0.3, 0.2]", "length_m"),
        ("[-0.06, 0.0, 0.0]", "[-0.06, 0.0, 0.0]\nlength_m = [-0.1, 0.2]", "length_m"),
        ("[-0.06, 0.0, 0.0]", "[-0.06, 0.0, 0.0]\nlength_m = [0.1, nan]", "length_m"),
    ] {
        let fault = refused(&KNEE.replace(good, bad), &format!("actuator 'knee' {field}"));
        assert!(matches!(fault, RobotFault::BadValue { .. }), "{fault}");
    }
    for (good, bad, field) in [
        ("sign = -1", "sign = 2", "sign"),
        ("length_mid_m = 0.33", "length_mid_m = inf", "length_mid_m"),
        ("[0.0, 0.0, -1.0]", "[0.0, 0.0, 0.0]", "axis_1"),
        ("joint = \"knee\"", "joint = \"hip\"", "joint"),
    ] {
        refused(&format!("\n{}", HOEKENS.replace(good, bad)), &format!("actuator 'knee' {field}"));
    }
}

#[test]
fn names_used_twice() {
    let twice = format!("{KNEE}\n{}", KNEE.replace("# The knee alone.\n", ""));
    let (line, what, fault) = taken_apart(place(&twice).expect_err("must be refused"));
    assert_eq!((line, what.as_str()), (Some(12), "actuator 'knee' name"));
    assert_eq!(fault, RobotFault::Duplicate("knee".to_owned()));
}

#[test]
fn lengths_that_the_stroke_does_not_allow() {
    let robot = place(KNEE).expect("good");
    // 0.25 m down and 10 mm back at zero: within 0.20 to 0.31 m. Straightened far back it is too long.
    assert!(robot.check_strokes(&[0.0, 0.0], "the start posture").is_ok());
    let error = robot.check_strokes(&[0.0, -1.5], "the start posture").expect_err("too long");
    let (_, element, fault) = taken_apart(error);
    assert_eq!(element, "actuator 'knee'");
    let RobotFault::OutOfStroke { length_m, min_m, max_m, posture } = fault else { panic!("{fault}") };
    assert!(length_m > max_m && min_m < max_m);
    assert_eq!(posture, "the start posture");
}

#[test]
fn sprung_mass_that_a_link_does_not_have() {
    // As bulky as a real thigh: 0.65 kg can be taken out a quarter of a metre from the centre.
    let leg = leg().replace("=\"0.02\"", "=\"0.2\"").replace("=\"0.01\"", "=\"0.1\"");
    let with = |urdf: &str, link: &str| {
        let text = format!("{KNEE}sprung_mass_in = \"{link}\"\n");
        Robot::from_urdf(urdf, "r.urdf", None).expect("a leg").with_placement(&text, "r.toml", None)
    };
    let whole = with(&leg, "thigh").expect("fits");
    assert_eq!(whole.actuators[0].sprung_mass_in, Some(1));
    // Table 5: 0.6461 kg, at the spring side's attachment a quarter of a metre below the centre.
    let rest = whole.clone().without_sprung_masses().expect("fits");
    assert_eq!(rest.actuators[0].sprung_mass_in, None);
    let body = rest.links[1].inertial.as_ref().expect("has mass");
    assert!((body.mass_kg - (2.0 - 0.6461)).abs() < 1e-12);
    assert!((body.com.z - 0.6461 * 0.25 / body.mass_kg).abs() < 1e-12, "{}", body.com);
    let (_, element, fault) = taken_apart(with(&leg, "base").expect_err("not between"));
    assert_eq!(element, "actuator 'knee' sprung_mass_in");
    assert!(matches!(fault, RobotFault::Invalid(_)), "{fault}");
    let light = leg.replace("mass value=\"2\"", "mass value=\"0.5\"");
    let (_, _, fault) = taken_apart(with(&light, "thigh").expect_err("too heavy"));
    assert!(matches!(fault, RobotFault::SprungMassTooLarge { mass_kg, .. } if mass_kg > 0.6), "{fault}");
}
