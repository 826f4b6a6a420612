//! Time to read a run of a million rows of four columns, beside the least that any reader of the CSV has to do:
//! splitting its lines.

use criterion::{Criterion, criterion_group, criterion_main};
use sealegs_sysid::Campaign;
use std::fmt::Write;
use std::hint::black_box;

const ROWS: u32 = 1_000_000;

fn reading(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut csv = String::from("time_s,current_a,force_1_n,force_2_n\n");
    for i in 0..ROWS {
        let t = f64::from(i) * 1e-3;
        let _ = writeln!(csv, "{t:.4},{:.5},{:.3},{:.3}", 2.0 * t.sin(), 1e3 * t.cos(), 1e3 * t.sin());
    }
    let path = folder.path().join("r.csv");
    std::fs::write(&path, csv).expect("room on the disk");
    let toml = "bench = \"locked\"\nactuator = \"a\"\n[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n";
    std::fs::write(folder.path().join("campaign.toml"), toml).expect("room on the disk");
    let mut group = criterion.benchmark_group("a million rows");
    group.sample_size(10);
    group.bench_function("lines split", |b| {
        b.iter(|| {
            let bytes = std::fs::read(&path).expect("it is there");
            bytes.split(|&byte| byte == b'\n').map(|line| black_box(line).len()).sum::<usize>()
        });
    });
    group.bench_function("campaign read", |b| b.iter(|| Campaign::read(folder.path()).expect("good")));
    group.finish();
}

criterion_group!(benches, reading);
criterion_main!(benches);
