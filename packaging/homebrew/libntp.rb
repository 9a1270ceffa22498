# SPDX-License-Identifier: MIT
class Libntp < Formula
  desc "Checks, repairs, converts and makes normals textures (normal maps)"
  homepage "https://example.com/libntp"
  url "https://example.com/libntp/releases/download/v0.0.0/libntp-0.0.0.tar.gz"
  sha256 "0"
  license "MIT"

  depends_on "meson" => :build
  depends_on "ninja" => :build
  depends_on "pkgconf" => [:build, :test]

  depends_on "jansson"
  depends_on "jpeg-turbo"
  depends_on "libdeflate"
  depends_on "libpng"
  depends_on "openexr"
  depends_on "popt"
  depends_on "webp"
  depends_on "zstd"

  uses_from_macos "zlib"

  def install
    system "meson", "setup", "build", "-Djpeg=enabled", "-Dlibdeflate=enabled", "-Dzstd=enabled",
           "-Dwebp=enabled", "-Dexr=enabled", "-Dgegl=disabled", "-Dgimp=disabled", "-Dtests=false", *std_meson_args
    system "meson", "compile", "-C", "build", "--verbose"
    system "meson", "install", "-C", "build"
    pkgshare.install "examples/clean_texture.c", "test_files/standard_z_off.png"
  end

  test do
    system bin/"ntp", "clean", pkgshare/"standard_z_off.png", "-o", "clean.png"
    system bin/"ntp", "check", "clean.png"

    flags = shell_output("pkgconf --cflags --libs libntp").chomp.split
    system ENV.cc, pkgshare/"clean_texture.c", "-o", "clean_texture", *flags
    system "./clean_texture"
  end
end
