#!/usr/bin/env bash
# Makes what is published of a version: one static Linux program with man pages and completions, the Python wheel, and
# their checksums: release/build.sh [--musl] [--no-wheel] [FOLDER]   (FOLDER: target/dist)
#
# The program is linked statically against glibc, so that it runs on any Linux of the same processor and its numbers are those
# of the tests to the last bit. --musl links against musl instead, whose mathematical functions round otherwise; it needs
# Rust's musl target and musl-gcc. Needs Rust, a C compiler with libc.a (Debian: libc6-dev), and Python 3.11 for the wheel.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
processor=$(uname -m)
libc=gnu wheel=yes folder=
fail() { echo "release/build.sh: $*" >&2; exit 2; }
for argument in "$@"; do
  case $argument in
    --musl) libc=musl ;;
    --no-wheel) wheel=no ;;
    -*) fail "no option $argument; --musl and --no-wheel are known" ;;
    *) folder=$argument ;;
  esac
done
[ "$(uname -s)" = Linux ] || fail "makes Linux programs on Linux; elsewhere: cargo install --path crates/cli --locked"
for tool in cargo cc tar sha256sum ldd; do
  command -v "$tool" >/dev/null || fail "$tool is missing"
done

cd "$root"
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
folder=$(realpath -m "${folder:-$target/dist}")
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)

# Only the program itself is compiled with the flag: what is linked into it does not depend on it.
static=(-C target-feature=+crt-static)
built=$target/release
platform=()
if [ $libc = musl ]; then
  platform=(--target "$processor-unknown-linux-musl")
  built=$target/$processor-unknown-linux-musl/release
  [ -f "$(rustc --print target-libdir "${platform[@]}" 2>/dev/null)/self-contained/libc.a" ] \
    || fail "Rust's musl target is missing: rustup target add $processor-unknown-linux-musl, or build without --musl"
  command -v musl-gcc >/dev/null \
    || fail "musl-gcc is missing, which compiles Zstandard and LZ4: apt install musl-tools, or build without --musl"
else
  [ -f "$(cc -print-file-name=libc.a)" ] || fail "libc.a is missing (Debian: apt install libc6-dev)"
fi
cargo rustc --release --locked -p sealegs-cli --bin sealegs "${platform[@]}" -- "${static[@]}"
program=$built/sealegs
if ldd "$program" 2>&1 | grep -q '=>'; then
  fail "$program needs shared libraries: $(ldd "$program" | tr -s '\n\t' '  ')"
fi

name=sealegs-$version-$processor-linux
[ $libc = musl ] && name=$name-musl
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
mkdir -p "$folder" "$stage/$name/completions"
cp "$program" README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$stage/$name/"
"$program" man -o "$stage/$name/man"
for shell in bash zsh fish powershell; do
  "$program" completions "$shell" >"$stage/$name/completions/sealegs.$shell"
done
# It has to run where nothing else is: its presets and scenarios are inside.
(cd "$stage" && env -i "$stage/$name/sealegs" run thor-drop >/dev/null) || fail "the program does not run"

# The same sources give the same archive.
date=$(git log -1 --format=%ct 2>/dev/null || echo 0)
made=("$name.tar.gz")
tar --sort=name --mtime="@$date" --owner=0 --group=0 --numeric-owner -C "$stage" -cf - "$name" \
  | gzip -9n >"$folder/$name.tar.gz"

if [ $wheel = yes ]; then
  wheel=$("$root/py-sealegs/wheel.sh")
  cp "$wheel" "$folder/"
  made+=("$(basename "$wheel")")
fi
(cd "$folder" && sha256sum "${made[@]}" >SHA256SUMS)
printf 'program %s bytes, in %s:\n' "$(stat -c %s "$program")" "$folder"
cat "$folder/SHA256SUMS"
