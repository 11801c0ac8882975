"""Make the extension's zip: the package, the manifest, and embreex for the Pythons that Blender has.

    python tools/extension.py [--platform linux-x64 … | all | here] [--python 3.11 …] [--out dist]

One zip for each platform: dist/pt_engine-VERSION-PLATFORM.zip. numpy and OpenImageIO are Blender's own.
"""

from __future__ import annotations

import argparse
import platform
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EMBREEX = "embreex==4.4.0.post1"
PYTHONS = ("3.11", "3.13", "3.14")  # Blender 4.5 and 5.0; 5.1 and 5.2; builds by Linux distributions
PLATFORMS = {  # Blender's name: pip's
    "linux-x64": "manylinux_2_28_x86_64",
    "windows-x64": "win_amd64",
    "macos-arm64": "macosx_13_0_arm64",
    "macos-x64": "macosx_13_0_x86_64",
}
SUFFIXES = {".py", ".txt", ".html", ".npz", ".npy", ".json", ".toml"}  # of the package's files
STAMP = (2026, 1, 1, 0, 0, 0)  # the same content gives the same zip


def main() -> None:
    """Build what the command line asks for, and print each zip's path."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--platform", nargs="+", default=["here"], choices=[*PLATFORMS, "all", "here"])
    parser.add_argument("--python", nargs="+", default=PYTHONS)
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    arguments = parser.parse_args()
    for name in platforms(arguments.platform):
        print(build(name, arguments.python, arguments.out))


def platforms(asked: list[str]) -> list[str]:
    """`all` and `here` as names of platforms."""
    names = dict.fromkeys(PLATFORMS) if "all" in asked else dict.fromkeys(asked)
    return [this_platform() if name == "here" else name for name in names]


def this_platform() -> str:
    """Blender's name of the machine this runs on."""
    system = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}.get(platform.system(), "")
    machine = "arm64" if platform.machine().lower() in ("arm64", "aarch64") else "x64"
    name = f"{system}-{machine}"
    if name not in PLATFORMS:
        sys.exit(f"there is no embreex for {platform.system()} on {platform.machine()}")
    return name


def build(name: str, pythons: list[str], out: Path) -> Path:
    """One platform's zip."""
    manifest = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    wheels = [fetched_wheel(name, python, out / "wheels") for python in pythons]
    names = ", ".join(f'"./wheels/{wheel.name}"' for wheel in wheels)
    lists = f'platforms = ["{name}"]\nwheels = [{names}]\n\n'
    manifest = manifest.replace("[permissions]", lists + "[permissions]")
    path = out / f"pt_engine-{tomllib.loads(manifest)['version']}-{name}.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        write(archive, "blender_manifest.toml", manifest.encode())
        for file in (ROOT / "__init__.py", ROOT / "LICENSE", *package_files()):
            if file.exists():
                write(archive, file.relative_to(ROOT).as_posix(), file.read_bytes())
        for file in wheels:
            write(archive, f"wheels/{file.name}", file.read_bytes(), zipfile.ZIP_STORED)
    return path


def package_files() -> list[Path]:
    """Every file of the package, and nothing that Python or an editor left there."""
    files = (ROOT / "pt_engine").rglob("*")
    return sorted(f for f in files if f.suffix in SUFFIXES and "__pycache__" not in f.parts)


def fetched_wheel(name: str, python: str, folder: Path) -> Path:
    """embreex for a platform and a Python, from the package index or from an earlier build."""
    tag = python.replace(".", "")
    system = PLATFORMS[name].partition("_")[0]
    machine = PLATFORMS[name].rpartition("_")[2]
    package, version = EMBREEX.split("==")
    folder.mkdir(parents=True, exist_ok=True)
    pattern = f"{package}-{version}-cp{tag}-*{system}*{machine}.whl"
    if not list(folder.glob(pattern)):
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
        pip += ["--only-binary", ":all:", "--python-version", python, "--platform", PLATFORMS[name]]
        subprocess.run([*pip, "--dest", str(folder), EMBREEX], check=True)
    return next(folder.glob(pattern))


def write(archive: zipfile.ZipFile, name: str, data: bytes, method: int = zipfile.ZIP_DEFLATED) -> None:
    """Add a file whose entry does not depend on the day or on who builds."""
    entry = zipfile.ZipInfo(name, STAMP)
    entry.compress_type = method
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, data)


if __name__ == "__main__":
    main()
