//! Every URDF that is refused, with line, element and fault.

use super::*;

fn refused(urdf: &str, line: u32, element: &str) -> RobotFault {
    let (at, what, fault) = refusal(urdf);
    assert_eq!((at, what.as_str()), (Some(line), element), "{fault}");
    fault
}

fn strictly(urdf: &str, line: u32, element: &str) -> RobotFault {
    let (at, what, fault) = strict_refusal(urdf);
    assert_eq!((at, what.as_str()), (Some(line), element), "{fault}");
    fault
}

#[test]
fn text_that_is_no_xml() {
    let fault = refused("<robot name=\"r\">\n<link name=\"a\">\n</robot>", 3, "URDF");
    assert!(matches!(fault, RobotFault::NotXml(_)), "{fault}");
    let (_, _, fault) = refusal("solid mesh");
    assert!(matches!(fault, RobotFault::NotXml(_)), "{fault}");
}

#[test]
fn xml_that_is_no_urdf() {
    let fault = refused("<sdf>\n</sdf>", 1, "URDF");
    assert!(fault.to_string().contains("<sdf>"), "{fault}");
}

#[test]
fn no_link_at_all() {
    let (_, _, fault) = refusal(&robot(""));
    assert_eq!(fault, RobotFault::NoLink);
}

#[test]
fn a_joint_to_a_link_that_is_not_there() {
    let urdf = robot(&(link("base") + &link("thigh") + &hinge("hip", "base", "thihg")));
    let fault = refused(&urdf, 4, "joint 'hip'");
    let suggestion = Some("thigh".to_owned());
    assert_eq!(fault, RobotFault::UnknownLink { name: "thihg".to_owned(), suggestion });
}

#[test]
fn a_cycle() {
    let links = ["base", "a", "b", "c"].map(link).concat();
    let joints = hinge("1", "a", "b") + &hinge("2", "b", "c") + &hinge("3", "c", "a");
    let (line, _, fault) = refusal(&robot(&(links + &joints)));
    let RobotFault::Cycle(ring) = fault else { panic!("{fault}") };
    assert_eq!(ring.first(), ring.last());
    let mut names = ring[1..].to_vec();
    names.sort();
    assert_eq!(names, ["a", "b", "c"]);
    assert!(line.is_some());
    // A link on itself, with nothing else.
    let (_, _, fault) = refusal(&robot(&(link("a") + &hinge("1", "a", "a"))));
    assert_eq!(fault, RobotFault::Cycle(vec!["a".to_owned(), "a".to_owned()]));
}

#[test]
fn two_roots() {
    let urdf = robot(&(link("base") + &link("thigh") + &link("other") + &hinge("hip", "base", "thigh")));
    let fault = refused(&urdf, 4, "link 'other'");
    assert_eq!(fault, RobotFault::Roots(vec!["base".to_owned(), "other".to_owned()]));
}

#[test]
fn two_parents() {
    let links = ["a", "b", "c"].map(link).concat();
    let joints = hinge("1", "a", "c") + &hinge("2", "b", "c");
    let fault = refused(&robot(&(links + &joints)), 6, "joint '2'");
    assert!(matches!(fault, RobotFault::TwoParents { .. }), "{fault}");
}

#[test]
fn names_used_twice() {
    let fault = refused(&robot(&(link("a") + &link("a"))), 3, "link 'a'");
    assert_eq!(fault, RobotFault::Duplicate("a".to_owned()));
    let links = ["a", "b", "c"].map(link).concat();
    let urdf = robot(&(links + &hinge("j", "a", "b") + &hinge("j", "b", "c")));
    assert_eq!(refused(&urdf, 6, "joint 'j'"), RobotFault::Duplicate("j".to_owned()));
}

#[test]
fn masses_that_are_not_positive() {
    for mass in ["0", "-1.5"] {
        let urdf = robot(&link("a").replace("mass value=\"2\"", &format!("mass value=\"{mass}\"")));
        let fault = strictly(&urdf, 2, "link 'a' inertial mass");
        let value = mass.parse().expect("a number");
        assert_eq!(fault, RobotFault::BadValue { value, admitted: "positive" });
    }
    // No rounding makes this of a zero.
    refused(
        &robot(&link("a").replace("mass value=\"2\"", "mass value=\"-1.5\"")),
        2,
        "link 'a' inertial mass",
    );
}

#[test]
fn inertia_that_no_body_has() {
    // 0.02 + 0.02 < 0.05: the triangle inequality.
    let fault = strictly(&robot(&link("a").replace("0.01", "0.05")), 2, "link 'a' inertial inertia");
    let RobotFault::ImpossibleInertia(moments, why) = &fault else { panic!("{fault}") };
    assert!((moments[2] - 0.05).abs() < 1e-15 && why.contains("sum"), "{fault}");
    // Only the off-diagonal makes it indefinite: 0.02 - 0.03 < 0.
    let urdf = robot(&link("a").replace("ixy=\"0\"", "ixy=\"0.03\""));
    let fault = strictly(&urdf, 2, "link 'a' inertial inertia");
    assert!(matches!(fault, RobotFault::ImpossibleInertia(_, "each must be positive")), "{fault}");
    // A thin plate, printed with few digits, is a body: 0.0013 + 0.0021 = 0.0034.
    let plate = link("a").replace("ixx=\"0.02\"", "ixx=\"0.0013\"").replace("iyy=\"0.02\"", "iyy=\"0.0021\"");
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    let plate = robot(&plate.replace("0.01", "0.0034"));
    assert!(Robot::from_urdf_with(&plate, "r", None, &strict).is_ok());
}

#[test]
fn numbers_that_are_none() {
    for (good, bad, element) in [
        ("value=\"2\"", "value=\"nan\"", "link 'base' inertial mass value"),
        ("ixx=\"0.02\"", "ixx=\"inf\"", "link 'base' inertial inertia ixx"),
        ("ixx=\"0.02\"", "ixx=\"o.2\"", "link 'base' inertial inertia ixx"),
        ("xyz=\"0 0 -0.5\"", "xyz=\"0 x 0 -0.5\"", "joint 'hip' origin xyz"),
        ("xyz=\"0 1 0\"", "xyz=\"0 1\"", "joint 'hip' axis xyz"),
        ("upper=\"2\"", "upper=\"NaN\"", "joint 'hip' limit upper"),
    ] {
        let (line, what, fault) = refusal(&leg().replacen(good, bad, 1));
        assert_eq!(what, element);
        assert!(line.is_some());
        assert!(matches!(fault, RobotFault::BadValue { .. } | RobotFault::NotUrdf(_)), "{fault}");
    }
}

#[test]
fn what_is_missing() {
    for (there, element, missing) in [
        ("<parent link=\"base\"/>", "joint 'hip'", "<parent>"),
        (" link=\"base\"", "joint 'hip' parent", "attribute 'link'"),
        (" type=\"revolute\"", "joint 'hip'", "attribute 'type'"),
        ("<mass value=\"2\"/>", "link 'base' inertial", "<mass>"),
        (" izz=\"0.01\"", "link 'base' inertial inertia", "attribute 'izz'"),
        (" velocity=\"5\"", "joint 'hip' limit", "attribute 'velocity'"),
        ("<limit lower=\"-2\" upper=\"2\" effort=\"100\" velocity=\"5\"/>", "joint 'hip'", "<limit>"),
        (" name=\"hip\"", "joint ''", "attribute 'name'"),
    ] {
        let (line, what, fault) = strict_refusal(&leg().replacen(there, "", 1));
        assert_eq!((what.as_str(), fault), (element, RobotFault::Missing(missing.to_owned())));
        assert!(line.is_some(), "{element}");
    }
}

#[test]
fn an_axis_without_direction() {
    let fault = refused(&leg().replacen("xyz=\"0 1 0\"", "xyz=\"0 0 0\"", 1), 5, "joint 'hip' axis");
    assert_eq!(fault, RobotFault::ZeroAxis);
}

#[test]
fn limits_crossed_or_negative() {
    let fault = refused(&leg().replacen("upper=\"2\"", "upper=\"-3\"", 1), 5, "joint 'hip' limit");
    assert_eq!(fault, RobotFault::LimitsCrossed { lower: -2.0, upper: -3.0 });
    let fault = refused(&leg().replacen("effort=\"100\"", "effort=\"-1\"", 1), 5, "joint 'hip' limit");
    assert!(matches!(fault, RobotFault::BadValue { value: -1.0, .. }), "{fault}");
}

#[test]
fn losses_that_would_feed_energy() {
    let urdf = leg().replacen("<axis", "<dynamics damping=\"-0.1\"/><axis", 1);
    let fault = refused(&urdf, 5, "joint 'hip' dynamics");
    assert!(matches!(fault, RobotFault::BadValue { value: -0.1, .. }), "{fault}");
}

#[test]
fn shapes_without_size() {
    let flat = "<collision><geometry><box size=\"0.1 0 0.1\"/></geometry></collision></link>";
    let (_, what, fault) = refusal(&leg().replacen("</link>", flat, 1));
    assert_eq!(what, "link 'base' collision geometry");
    assert_eq!(fault, RobotFault::BadValue { value: 0.0, admitted: "positive" });
}

#[test]
fn a_missing_mesh() {
    let mesh = "<visual><geometry><mesh filename=\"foot.stl\"/></geometry></visual></link>";
    let (line, what, fault) = strict_refusal(&leg().replacen("</link>", mesh, 1));
    assert_eq!((line, what.as_str()), (Some(2), "link 'base' visual geometry"));
    assert!(fault.to_string().contains("'foot.stl': no such file"), "{fault}");
}

#[test]
fn joints_that_cannot_be_left_out() {
    for kind in ["floating", "planar", "spherical", "screw"] {
        let urdf = leg().replacen("type=\"revolute\"", &format!("type=\"{kind}\""), 1);
        let fault = refused(&urdf, 5, "joint 'hip'");
        assert_eq!(fault, RobotFault::UnsupportedJoint(kind.to_owned()));
    }
}

#[test]
fn a_moving_joint_with_nothing_behind_it() {
    let urdf = robot(&(link("base") + "<link name=\"tip\"/>\n" + &hinge("j", "base", "tip")));
    let fault = strictly(&urdf, 4, "joint 'j'");
    assert!(matches!(fault, RobotFault::Missing(_)), "{fault}");
}

#[test]
fn a_robot_that_is_nowhere() {
    let message = |name: &str| Robot::load(name, None).expect_err("is not there").to_string();
    assert!(message("thor-lge").contains("did you mean 'thor-leg'?"), "{}", message("thor-lge"));
    assert!(message("no/such/leg.urdf").starts_with("no/such/leg.urdf: "), "{}", message("no/such/leg.urdf"));
}
