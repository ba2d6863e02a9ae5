#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""The Debian packages in a fresh Debian 12 without a compiler: installed, used and removed.

Usage: package_test.py BUILD [PACKAGES]    PACKAGES: a folder of packages that cpack has made; else they are made"""
import gzip
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
SUITE = "bookworm"
PACKAGES = ("panoptic", "libpanoptic-dev", "python3-panoptic")
COMPILER = ("g++", "cmake", "make")  # of whoever builds with the library
CONSUMER = pathlib.Path(__file__).resolve().parent.parent / "consumer"
SOURCES = pathlib.Path("/etc/apt")


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def must(*command, **more):
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, stdin=subprocess.DEVNULL, **more)
    if done.returncode != 0:
        sys.exit(f"failed: {' '.join(map(str, command))}\n{done.stdout[-4000:]}")
    return done.stdout


def mirror():
    """The one that this machine uses."""
    for path in [SOURCES / "sources.list", *sorted(SOURCES.glob("sources.list.d/*"))]:
        if path.is_file():
            found = re.search(r"https?://\S+/debian/?(?=\s|$)", path.read_text(encoding="utf-8"))
            if found:
                return found[0]
    return None


class FreshDebian:
    def __init__(self, folder):
        self.root = folder / "root"
        self.root.mkdir()
        made = subprocess.run(["debootstrap", "--variant=minbase", SUITE, self.root, mirror()], capture_output=True, text=True, check=False)
        if made.returncode != 0:
            skip(f"debootstrap made no fresh Debian: {made.stdout.strip().splitlines()[-1:] or made.stderr.strip()}")
        for name in ("resolv.conf", "hosts"):
            shutil.copy(f"/etc/{name}", self.root / "etc" / name)
        must("mount", "-t", "proc", "proc", self.root / "proc")

    def end(self):
        subprocess.run(["umount", self.root / "proc"], check=False)

    def run(self, *command):
        environment = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/", "LC_ALL": "C", "DEBIAN_FRONTEND": "noninteractive"}
        environment.update({name: os.environ[name] for name in ("http_proxy", "https_proxy", "no_proxy") if name in os.environ})
        return must("chroot", self.root, *command, env=environment)


def use(debian):
    assert "/usr/bin/panoptic" in debian.run("sh", "-c", "command -v panoptic")
    debian.run("sh", "-c", "! command -v g++ && ! command -v gcc && ! command -v cc")
    assert "panoptic 0" in debian.run("panoptic", "--version")
    said = debian.run("panoptic", "run", "sim:1,rooms=1,frames=5", "--no-pictures", "--set", "map.voxel_size_m=0.06", "-o", "/out")
    assert "5 frames used" in said, said
    for file in ("mesh.ply", "objects.json", "report.json"):
        assert (debian.root / "out" / file).stat().st_size > 0
    if (debian.root / "usr/lib/panoptic/libonnxruntime.so.1").exists():  # a build without it runs networks on OpenCV
        assert "libonnxruntime.so.1 => /usr/lib/panoptic" in debian.run("sh", "-c", "ldd /usr/bin/panoptic | sed 's,/usr/bin/../,/usr/,'")
    assert "not found" not in debian.run("ldd", "/usr/bin/panoptic")
    page = gzip.decompress((debian.root / "usr/share/man/man1/panoptic.1.gz").read_bytes()).decode().replace("\\-", "-")
    commands = re.findall(r"^  ([a-z][a-z-]*) ", debian.run("panoptic", "--help").partition("Subcommands:")[2].partition("\n\n")[0], re.M)
    missing = [command for command in commands if f"\n.B {command}\n" not in page]
    assert "play" in commands and not missing, f"the man page lacks {missing} of {commands}"
    words = debian.run("bash", "-c", "source /usr/share/bash-completion/completions/panoptic; COMP_WORDS=(panoptic ba); COMP_CWORD=1; "
                       "_panoptic; echo ${COMPREPLY[@]}; COMP_WORDS=(panoptic batch --slurm-o); COMP_CWORD=2; _panoptic; echo ${COMPREPLY[@]}")
    assert words.split() == ["batch", "--slurm-option"], words
    assert "1 labels" in debian.run("python3", "-c", "import panoptic, sys; m = panoptic.Mapper(); print(1, 'labels', m)")


def build_with(debian):
    """Somebody else's program on the whole library: the package asks for all that it needs."""
    shutil.copytree(CONSUMER, debian.root / "consumer")
    debian.run("cmake", "-S", "/consumer", "-B", "/consumer/build", "-DWHOLE=ON")
    debian.run("cmake", "--build", "/consumer/build")
    debian.run("/consumer/build/consumer")


def main():
    missing = [name for name in ("debootstrap", "cpack", "dpkg-shlibdeps", "chroot") if not shutil.which(name)]
    if missing:
        skip(f"no {', '.join(missing)} here")
    if f"VERSION_CODENAME={SUITE}" not in pathlib.Path("/etc/os-release").read_text(encoding="utf-8"):
        skip(f"the packages of this machine are not for Debian {SUITE}")
    if not mirror():
        skip("no Debian mirror in /etc/apt")
    if subprocess.run(["id", "-u"], capture_output=True, text=True, check=True).stdout.strip() != "0":
        skip("debootstrap needs root")
    build = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="panoptic_packages_") as name:
        folder = pathlib.Path(name)
        packages = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else folder / "packages"
        if len(sys.argv) < 3:
            must("cpack", "--config", build / "CPackConfig.cmake", "-B", packages)
        if not list(packages.glob("python3-panoptic_*.deb")):
            skip("this build has no Python module")
        debian = FreshDebian(folder)
        try:
            for package in packages.glob("*.deb"):
                shutil.copy(package, debian.root)
            debian.run("apt-get", "update")
            before = debian.run("sh", "-c", "dpkg-query -W -f '${Package}\\n'")
            # Without what is recommended but furniture: that is what simulated homes are made of.
            debian.run("sh", "-c", "apt-get install -y --no-install-recommends ./panoptic_*.deb ./python3-panoptic_*.deb sweethome3d-furniture")
            use(debian)
            debian.run("sh", "-c", "apt-get install -y --no-install-recommends ./libpanoptic-dev_*.deb")
            debian.run("apt-get", "install", "-y", "--no-install-recommends", *COMPILER)
            build_with(debian)
            debian.run("apt-get", "purge", "-y", *PACKAGES, *COMPILER, "sweethome3d-furniture")
            debian.run("apt-get", "autoremove", "-y", "--purge")
            assert debian.run("sh", "-c", "dpkg-query -W -f '${Package}\\n'") == before
            left = [p for p in debian.root.glob("usr/**/*panoptic*")]
            assert not left, f"left behind: {left}"
        finally:
            debian.end()
    print("installed, used and removed")


if __name__ == "__main__":
    main()
