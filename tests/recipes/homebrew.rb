# SPDX-License-Identifier: MIT
# Runs a formula without Homebrew: ruby homebrew.rb FORMULA ARCHIVE WORK
# Dependencies are those of the system; each method does what Homebrew's does, of what a formula asks.
require "digest"
require "fileutils"
require "pathname"

class Pathname
  def install(*files)
    mkpath
    files.each { |file| FileUtils.cp(file, self) }
  end
end

module ENVcc
  def cc
    "cc"
  end
end
ENV.extend(ENVcc)

class Formula
  class << self
    attr_reader :said, :tested

    %i[desc homepage url sha256 license].each do |name|
      define_method(name) { |value| (@said ||= {})[name] = value }
    end

    def depends_on(_what); end

    def uses_from_macos(_what); end

    def test(&block)
      @tested = block
    end
  end

  def initialize(prefix)
    @prefix = Pathname(prefix)
  end

  def bin
    @prefix/"bin"
  end

  def pkgshare
    @prefix/"share/libntp"
  end

  def std_meson_args
    ["--prefix=#{@prefix}", "--libdir=lib", "--buildtype=release", "--wrap-mode=nofallback"]
  end

  def system(*command)
    Kernel.system(*command.map(&:to_s), out: File::NULL) or abort("failed: #{command.join(" ")}")
  end

  def shell_output(command)
    output = `#{command}`
    $?.success? ? output : abort("failed: #{command}")
  end
end

formula, archive, work = ARGV.map { |name| File.expand_path(name) }
load formula
said = Libntp.said
abort("desc is longer than 80 characters") if said[:desc].length > 80
abort("not the archive of its url") if File.basename(said[:url]) != File.basename(archive)
abort("not its sha256") if said[:sha256] != Digest::SHA256.file(archive).hexdigest

FileUtils.mkpath("#{work}/test")
ENV["PKG_CONFIG_PATH"] = "#{work}/prefix/lib/pkgconfig"
ENV["LD_LIBRARY_PATH"] = "#{work}/prefix/lib" # Homebrew's linker writes it into the program
Kernel.system("tar", "-xf", archive, "-C", work) or abort("failed: tar")
libntp = Libntp.new("#{work}/prefix")
Dir.chdir("#{work}/#{File.basename(archive, ".tar.gz")}") { libntp.install }
Dir.chdir("#{work}/test") { libntp.instance_exec(&Libntp.tested) }
