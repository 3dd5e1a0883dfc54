#!/usr/bin/env bash
# Follows docs/adding-a-stage.md to the letter in an empty folder, then builds what `mimesh new plugin` writes for a transfer and holds
# it to its contract; with `--every-kind`, which takes minutes, for every kind of stage.
#
# The blocks of the page are followed in order:
# - sh is run line by line in one shell;
# - text is what the block before printed, among other things, in this order; one that begins with `error:` must have failed;
# - rust and yaml are the file named last, between backticks, in the lines before.
#
# Takes the crates in $CARGO_TARGET_DIR, or in target/ of this repository, as far as they are built there.
set -euo pipefail
case ${1:-} in
'' | --every-kind) ;;
*) echo "usage: tests/adding_a_stage.sh [--every-kind]"; exit 2 ;;
esac
cd "$(dirname "$0")/.."
root=$PWD
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}
# Nothing is fetched that Cargo.lock does not name; after a build of the workspace, nothing at all.
[ "${CI:-}" = true ] || export CARGO_NET_OFFLINE=true

work=$(mktemp -d)
# Not the cache of the user.
export MIMESH_CACHE=$work/cache
crates=()
finish() {
    local status=$?
    # The crates lie in a folder of random name, so that nobody would ever use what was built of them again.
    for crate in "${crates[@]}"; do
        [ ! -f "$work/$crate/Cargo.toml" ] || (cd "$work/$crate" && cargo clean --quiet --release -p "${crate##*/}") || true
    done
    rm -rf "$work"
    [ $status = 0 ] || echo "tests/adding_a_stage.sh failed after ${SECONDS}s"
}
trap finish EXIT

# Each block as a file NUMBER.LANGUAGE, and for files their names in NUMBER.name.
mkdir "$work/blocks"
awk -v folder="$work/blocks" '
    /^```/ && !inside { inside = 1; n++; block = sprintf("%s/%03d", folder, n); out = block "." substr($0, 4); printf "" > out
                        print name > (block ".name"); close(block ".name"); next }
    /^```/            { inside = 0; close(out); next }
    inside            { print > out; next }
    { text = $0; while (match(text, /`[^`]+`/)) { name = substr(text, RSTART + 1, RLENGTH - 2); text = substr(text, RSTART + RLENGTH) } }
' docs/adding-a-stage.md

# Cargo builds the crates of mimesh again, since they lie outside of these workspaces. Crates that compute are optimized a little, and
# the others not at all: that is fastest in all. Crates of others are taken as they were built.
mkdir "$work/.cargo"
for manifest in {.,crates/*,plugins/*}/Cargo.toml; do
    case $manifest in
    plugins/formats/*) level=0 ;;
    crates/core/* | plugins/*) level=1 ;;
    *) level=0 ;;
    esac
    crate=$(sed -n 's/^name = "\(.*\)"$/\1/p' "$manifest" | head -n 1)
    printf '[profile.release.package.%s]\nopt-level = %s\n' "$crate" "$level"
done > "$work/.cargo/config.toml"

mkdir "$work/clean"
cd "$work/clean"
# The clone, and where `cargo install` puts programs.
ln -s "$root" mimesh
export CARGO_INSTALL_ROOT=$work/installed PATH="$work/installed/bin:$PATH"

# Runs each line of a block, and shows it; everything printed goes to the file `printed` too.
follow() {
    : > "$work/printed"
    while IFS= read -r -u 3 line; do
        printf '\n$ %s (%ss)\n' "$line" "$SECONDS"
        # In this shell, so that `cd` stays.
        eval "$line" > "$work/now" 2>&1 || { cat "$work/now"; cat "$work/now" >> "$work/printed"; return 1; }
        cat "$work/now"
        cat "$work/now" >> "$work/printed"
    done 3< "$1"
}

# Checks that the lines of a block were printed, in this order, however wide their columns are.
printed() {
    local from=1 at
    tr -s ' ' < "$work/printed" > "$work/now"
    while IFS= read -r line; do
        line=$(tr -s ' ' <<< "$line" | sed 's/^ //; s/ $//')
        # No pipe: `grep` stops at the first match, and a `tail` that still writes would make that a failure.
        at=$(grep -nF -m 1 -- "$line" <(tail -n +"$from" "$work/now") | cut -d: -f1) \
            || { printf '\nthe page shows that this is printed:\n%s\n' "$line"; return 1; }
        from=$((from + at))
    done < "$1"
}

echo "following docs/adding-a-stage.md"
crates+=(clean/extremes)
for block in "$work"/blocks/*; do
    next=$(printf '%s/%03d.text' "$work/blocks" $((10#$(basename "${block%.*}") + 1)))
    case $block in
    *.name) ;;
    *.sh)
        if head -n 1 "$next" 2> /dev/null | grep -q '^error:'; then
            ! follow "$block" || { echo "the page shows that this fails"; exit 1; }
        else
            follow "$block"
        fi
        ;;
    *.text) printed "$block" ;;
    *)
        name=$(cat "${block%.*}.name")
        # A sentence put between the name and the block would otherwise write another file, and the page would fail much later.
        [ -e "$name" ] || { echo "a block follows \`$name\`, which is no file that \`mimesh new\` wrote"; exit 1; }
        cp "$block" "$name"
        ;;
    esac
done
test -s horse.markers.yaml && ls out/*.obj > /dev/null
echo "the page holds (${SECONDS}s)"

# What is written for other kinds: builds, keeps its contract, and its pipeline does what its README says.
cd "$work/clean"
kinds=$(mimesh new plugin --help | tr -s '\n ' ' ' | sed -n 's/.*possible values: \([^]]*\)].*/\1/p' | tr -d ,)
[[ " $kinds " = *" transfer "* ]] || { echo "mimesh new plugin --help does not name the kinds: $kinds"; exit 1; }
[ "${1:-}" = --every-kind ] || kinds=transfer
for kind in $kinds; do
    [ "$kind" != sampler ] || continue
    crate=own-${kind//_/-}
    crates+=("clean/$crate")
    printf '%s\n' "mimesh new plugin $crate --stage $kind" "cd $crate" "cargo test --quiet --release" > "$work/block"
    follow "$work/block"
    grep '^cargo run --release -- .*pipeline.yaml' README.md > "$work/block"
    follow "$work/block"
    cd ..
done
printf '\nworks: %s (%ss)\n' "$kinds" "$SECONDS"
