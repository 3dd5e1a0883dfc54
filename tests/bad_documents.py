#!/usr/bin/env python3
"""Runs `check` and `run` on some 200 bad pipelines, includes and markers, and says how each ends.

    python3 tests/bad_documents.py [MIMESH]

A pipeline is told clearly if the first error names a place or a file and either the message or a hint says a way out; it is dead if the
command panics, hangs for 10 s, needs more than 1 GB or ends by a signal. The exit status is the number of those that are dead or vague.
"""

import contextlib
import os
import re
import resource
import subprocess
import sys
import tempfile

MIMESH = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else "target/release/mimesh")
SECONDS, MEMORY = 10, 1 << 30

CUBE = "".join(f"v {i & 1} {2 * (i >> 1 & 1)} {3 * (i >> 2 & 1)}\n" for i in range(8))
CUBE += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
GOOD = {
    "source": "{ rest: rest.obj, poses: pose-*.obj }",
    "target": "{ rest: target.obj }",
    "correspondence": "{ type: identity }",
    "transfer": "{ type: copy_displacement }",
    "output": "out/{pose}.obj",
}
ENDS = set(range(0, 5)) - {1} | {65, 66, 73, 78}


def pipeline(before="", after="", **slots):
    keys = {**GOOD, **slots}
    return before + "".join(f"{key}: {value}\n" for key, value in keys.items() if value is not None) + after


def cases():
    """Names of cases with the bytes or the text of `p.yaml`, and the other files that they need."""
    text = lambda name, value, **files: (name, value, files)
    # Texts that are no YAML, or no pipeline.
    for i, bad in enumerate([
        "", " ", "\n" * 100000, "#", "---", "--- \n---", "...", "null", "~", "1", "[]", "{}", "- a", "text", "'", '"', "{", "[", "]", "}",
        "a: [", "a: {", "a: b: c", "\ta: 1", "a:\n\t- b", "? a", "? [a]\n: b", "1: 2", "~: 1", "true: 1", "{}: 1", "[]: {}", "&a", "*a", "&a *a",
        "a: &a [*a]", "a: !!binary x", "!x y", "a: !!float x", "%YAML 9.9\n---\na: 1", "%TAG ! x\n---\na: 1", "a: |9\n x", "a: >\n", "a: 'b",
        "\ufeff", "\ufeff{}", "\0", "a\0: 1", "a: \x1b[31m", "\u2028a: 1", "a: \ud7ff", "<<: 1", "<<: [1]", "a: &a {b: *a}", "<<: *x",
    ]):
        yield text(f"yaml {i} {bad[:12]!r}", bad)
    for encoding in ("utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1", "shift-jis"):
        yield text(f"encoding {encoding}", ("# größe\n" if encoding != "shift-jis" else "# 形\n") .encode(encoding) + pipeline().encode(encoding))
    yield text("random bytes", bytes((i * 7919 + i // 7) % 256 for i in range(100000)))
    yield text("bytes 0xff", b"\xff" * 1000)
    # Much of everything.
    for n, item in (("texts", lambda v: "'" + v * 10 + "'"), ("lists", lambda v: "[" + ", ".join([v] * 10) + "]"),
                    ("maps", lambda v: "{" + ", ".join(f"k{i}: {v}" for i in range(10)) + "}")):
        lines = "".join(f"  v{i}: {item('${v%d}' % (i - 1))}\n" for i in range(1, 10))
        for slot in ("output", "metrics", "gates", "correspondence"):
            yield text(f"variables of {n} in {slot}", pipeline(f"variables:\n  v0: x\n{lines}", **{slot: "${v9}"}))
    chain = "".join(f"  v{i}: ${{v{i - 1}}}\n" for i in range(1, 6000))
    yield text("a row of variables", pipeline(f"variables:\n  v0: x\n{chain}", output="out/${v5999}{pose}.obj"))
    yield text("a circle of variables", pipeline("variables: { a: '${b}', b: '${a}' }\n", output="${a}{pose}.obj"))
    yield text("a variable of itself", pipeline("variables: { a: '${a}${a}${a}' }\n", output="${a}{pose}.obj"))
    yield text("many variables", pipeline("variables:\n" + "".join(f"  v{i}: x\n" for i in range(50000))))
    yield text("many names of variables", pipeline("variables: {a: 1}\n", output="[" + ", ".join("'${%s}'" % ("x" * i) for i in range(500)) + "]"))
    yield text("open braces", pipeline(output="'" + "${" * 10000 + "'"))
    yield text("many braces", pipeline(output="'" + "{pose}" * 10000 + ".obj'"))
    yield text("environment", pipeline(output="'${env:NOT_THERE}/{pose}.obj'"))
    aliases = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n" + "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 10))
    yield text("aliases", aliases + pipeline())
    merges = "a0: &a0 { x: 1 }\n" + "".join(f"a{i}: &a{i} {{ <<: [{', '.join([f'*a{i - 1}'] * 20)}] }}\n" for i in range(1, 10))
    yield text("merge keys", merges + pipeline())
    for n in (65, 1000, 100000):
        yield text(f"{n} sequences deep", "a: " + "[" * n + "\n" + pipeline())
        yield text(f"{n} mappings deep", "a: " + "{a: " * n + "\n" + pipeline())
        yield text(f"{n} blocks deep", "".join(" " * i + "a:\n" for i in range(min(n, 2000))) + pipeline())
        yield text(f"{n} closed deep", "a: " + "[" * n + "]" * n + "\n" + pipeline())
        yield text(f"{n} keys", pipeline(after="".join(f"k{i}: 1\n" for i in range(n))))
        yield text(f"{n} bytes of key", pipeline(after="k" * n + ": 1\n"))
        yield text(f"{n} bytes of path", pipeline(source="{ rest: " + "a" * n + ".obj }"))
        yield text(f"{n} folders of path", pipeline(output="o/" * n + "{pose}.obj"))
        yield text(f"{n} folders up", pipeline(output="x/../" * n + "x/{pose}.obj"))
        yield text(f"{n} paths", pipeline(source="{ rest: rest.obj, poses: [" + ", ".join(f"x{i}.obj" for i in range(n)) + "] }"))
        yield text(f"{n} numbers for paths", pipeline(source="{ rest: rest.obj, poses: [" + ", ".join(map(str, range(n))) + "] }"))
        yield text(f"{n} outputs", pipeline(output="[" + ", ".join(f"o{i}/{{pose}}.obj" for i in range(n)) + "]"))
        yield text(f"{n} metrics", pipeline(metrics="[" + ", ".join("{ type: x }" for _ in range(n)) + "]"))
        yield text(f"{n} gates", pipeline(gates="{" + ", ".join(f"g{i}: 1" for i in range(n)) + "}"))
        yield text(f"{n} values of a matrix", pipeline(matrix="{ transfer.x: [" + ", ".join(map(str, range(n))) + "] }"))
        yield text(f"{n} keys of a matrix", pipeline(matrix="{" + ", ".join(f"a.k{i}: [1]" for i in range(n)) + "}"))
        yield text(f"{n} targets", pipeline(target=None, targets="{" + ", ".join(f"t{i}: {{ rest: target.obj }}" for i in range(n)) + "}"))
        yield text(f"{n} documents", "---\na: 1\n" * n)
        yield text(f"{n} comments", "# x\n" * n + "a: 1\n")
        yield text(f"{n} includes", pipeline(include="[" + ", ".join(["x.yaml"] * n) + "]"))
    yield text("a large matrix", pipeline(matrix="{" + ", ".join(f"a.k{i}: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]" for i in range(9)) + "}"))
    yield text("a matrix of a deep key", pipeline(matrix="\n  ? " + "a." * 1000 + "b\n  : [1]"))
    yield text("a long line of wrong names", pipeline(after="gates: {" + ", ".join(f"g: '${{u{i}}}'" for i in range(20000)) + "}"))
    # Includes.
    tower = {f"d{i}.yaml": f"include: [d{i - 1}.yaml, d{i - 1}.yaml]\n" if i else "variables: {a: 1}\n" for i in range(25)}
    yield text("a tower of includes", pipeline(include="d24.yaml"), **tower)
    row = {f"c{i}.yaml": f"include: c{i - 1}.yaml\n" if i else "variables: {a: 1}\n" for i in range(2000)}
    yield text("a row of includes", pipeline(include="c1999.yaml"), **row)
    yield text("itself", pipeline(include="p.yaml"))
    yield text("each other", pipeline(include="a.yaml"), **{"a.yaml": "include: b.yaml\n", "b.yaml": "include: a.yaml\n"})
    for i, include in enumerate(["/dev/zero", "/dev/null", "/dev/stdin", "pipe", ".", "/", "none.yaml", "''", "[]", "{}", "1", "~", "[1]", "[[a.yaml]]",
                                 "closed.yaml", "broken", "round", "/etc/passwd", "rest.obj", "'${x}'", "a" * 5000, "'*.yaml'", "/proc/self/mem"]):
        yield text(f"include {include[:20]}", pipeline(include=include))
        if include not in ("''", "[]", "{}", "~"):
            yield text(f"markers {include[:20]}", pipeline(markers=include))
            yield text(f"rest {include[:20]}", pipeline(source=f"{{ rest: {include}, poses: pose-*.obj }}"))
            yield text(f"poses {include[:20]}", pipeline(source=f"{{ rest: rest.obj, poses: {include} }}"))
    # Globs.
    for pattern in ("/**/*.obj", "**", "/**", "/*/*/*/*/*", "***", "a**", "[", "[a", "[]]", "[!]", "[z-a]", "*/../*/../*/../*.obj", "/proc/**/*.obj", "?" * 4000,
                    "{a,b}.obj", "*" * 2000, "[[:alpha:]]*", "\\*", "pose-*", "*.none", "none/*.obj", "rest*.obj", "pipe*", "/dev/z*"):
        yield text(f"poses {pattern[:20]}", pipeline(source=f"{{ rest: rest.obj, poses: '{pattern}' }}"))
    # Outputs.
    for output in ("''", "~", "[]", "{}", "1", "a", "{pose}", "out", "out/", ".", "..", "/", "/dev/null", "/dev/full", "/dev/zero/{pose}.obj", "pose-{pose}.obj", "rest.obj",
                   "out/{pose}/x.obj", "{target}.obj", "{matrix}/{pose}.obj", "{name}.glb", "{x}{pose}.obj", "out/x.obj", "out/{pose}.glb", "out/{pose}.xyz", "out/{pose}.html",
                   "x" * 300 + "{pose}.obj", "x" * 300 + "/{pose}.obj", "[out/{pose}.obj, out/{pose}.obj]", "rest.obj/{pose}.obj", "pipe/{pose}.obj", "pipe.glb", "/proc/{pose}.obj",
                   "out/run.json", "[a/run.json]", "'a\\0{pose}.obj'", "\"a\\0{pose}.obj\"", "folder.glb", "round/{pose}.obj", "broken/{pose}.obj"):
        yield text(f"output {output[:30]}", pipeline(output=output))
    # Values of slots.
    for slot in ("source", "target", "correspondence", "transfer", "markers", "proximity", "metrics", "gates", "pictures", "formats", "truth", "key_points", "shapes", "targets",
                 "matrix", "variables", "output_unit", "output_up", "keep_correspondence"):
        for value in ("1", "-1e999", ".nan", ".inf", "1e400", "[[1]]", "{ type: 1 }", "{ type: x }", "{ type: ~ }", "'\u202e'", "{ rest: ~ }", "99999999999999999999999999"):
            yield text(f"{slot}: {value}", pipeline(**{slot: value}))
    # Markers.
    for i, bad in enumerate(["", "x", "{", "[]", "markers: 1", "markers: [1]", "markers: [{}]", "markers: [{ name: a, source: 99, target: 1 }]", "markers: [{ name: a, source: -1, target: 1 }]",
                             "markers: [{ name: a, source: 1e999, target: 1 }]", "markers: [{ source: .nan, target: 1 }]", "a: " + "[" * 100000, "markers:\n" + "- { name: a, source: 0, target: 0 }\n" * 1000]):
        yield text(f"markers.yaml {i}", pipeline(markers="m.yaml"), **{"m.yaml": bad})
        for ending in ("json", "csv", "cons", "pp", "pts", "fcsv", "landmarkAscii", "mrk.json", "glb"):
            if i < 4:
                yield text(f"markers {ending} {i}", pipeline(markers=f"m.{ending}"), **{f"m.{ending}": bad})
    for ending in ("json", "yaml", "csv", "pp"):
        yield text(f"deep markers.{ending}", pipeline(markers=f"m.{ending}"), **{f"m.{ending}": "[" * 100000 if ending != "pp" else "<a>" * 100000})
        yield text(f"UTF-16 markers.{ending}", pipeline(markers=f"m.{ending}"), **{f"m.{ending}": "a,b\n".encode("utf-16")})
        yield text(f"no text in markers.{ending}", pipeline(markers=f"m.{ending}"), **{f"m.{ending}": b"\xff\xfe\x00\xd8" * 100})
    # Other JSON.
    for bad in ("", "{}", "[]", "1", "{\"format\": 1}", "{\"format\": \"mimesh-correspondence\"}", "{\"format\": \"mimesh-correspondence\", \"version\": 1}",
                "{\"format\": \"mimesh-correspondence\", \"version\": 1, \"source_triangles\": 1e99, \"partners\": []}", "[" * 100000):
        yield text(f"correspondence {bad[:30]}", pipeline(correspondence="{ type: from_file, path: c.json }"), **{"c.json": bad})
    for poses in ("v 0 0 0\nf 1 1 1\n", "", "v nan 0 0\n" * 8, "v 1e999 0 0\n" * 8, CUBE.replace("f 1 3 4 2", "f 1 3 4 99")):
        yield text(f"pose {poses[:12]!r}", pipeline(), **{"pose-1.obj": poses})
        yield text(f"truth {poses[:12]!r}", pipeline(truth="truth-{pose}.obj"), **{"truth-1.obj": poses, "truth-2.obj": CUBE})


@contextlib.contextmanager
def temporary_folder():
    folder = tempfile.mkdtemp()
    try:
        yield folder
    finally:
        # Folders may lie within each other deeper than Python goes.
        subprocess.run(["rm", "-rf", folder], check=True)


def limits():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def run(folder, command):
    try:
        done = subprocess.run([MIMESH, command, "p.yaml", "--no-cache"], cwd=folder, preexec_fn=limits, timeout=SECONDS, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    except subprocess.TimeoutExpired:
        return "dead", f"more than {SECONDS} s"
    errors = done.stderr.decode(errors="replace")
    if "panicked" in errors or done.returncode not in ENDS:
        return "dead", f"status {done.returncode}: {errors[-300:]}"
    if done.returncode == 0:
        return "accepted", ""
    found = re.split(r"^error: ", errors, flags=re.M)[1:]
    first = found[0] if found else ""
    # The words of libraries and of Rust are no words of the user's.
    strange = re.search(r"budget breached|os error|stream did not|deserializ|invalid type|`\w+::|without a reason|a map\b|\(defined at|variant\b.*expected", first)
    has_place = re.match(r"[^\n]*?(\.\w+|/\w+|p\.yaml|/|\.)(:\d+)*: |[^\n]*\b\w+\.\w+", first)
    if len(errors) > 200_000 or not found or strange or not has_place or max(map(len, errors.splitlines())) > 5000:
        return "vague", errors[:600]
    return "clear", first.splitlines()[0][:200]


def main():
    counts, bad, said = {}, [], open(os.environ.get("SAID", os.devnull), "w")
    for name, value, files in cases():
        for command in ("check", "run"):
            with temporary_folder() as folder:
                at = lambda file: os.path.join(folder, file)
                write = lambda file, data: open(at(file), "wb").write(data if isinstance(data, bytes) else data.encode("utf-8", "surrogatepass"))
                for mesh in ("rest", "pose-1", "pose-2", "target"):
                    write(f"{mesh}.obj", CUBE)
                write("closed.yaml", "a: 1\n")
                os.chmod(at("closed.yaml"), 0)
                os.mkfifo(at("pipe"))
                os.mkdir(at("folder.glb"))
                os.symlink("none", at("broken"))
                os.symlink("round", at("round"))
                write("p.yaml", value)
                for file, data in files.items():
                    write(file, data)
                kind, message = run(folder, command)
            counts[kind] = counts.get(kind, 0) + 1
            said.write(f"{kind}\t{command}\t{name}\t{message}\n")
            if kind in ("dead", "vague"):
                bad.append(f"{kind}: {command} {name}\n    {message}")
    print("\n".join(bad))
    print(", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))
    return min(len(bad), 100)


if __name__ == "__main__":
    sys.exit(main())
