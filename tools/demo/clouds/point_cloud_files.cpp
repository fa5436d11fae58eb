#include "tools/demo/clouds/point_cloud_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "core/platform/file_descriptor.h"
#include "tools/demo/clouds/file_formats.h"
#include "tools/terminal/units.h"

namespace sft::demo {

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

constexpr std::size_t memory_max =
    1024 * 1024 * 1024;  // for all clouds, which are kept and published again and again

struct Format {
  std::string_view extension;
  bool encoded;
  Result<std::vector<InputCloud>> (*read)(std::span<const std::byte> file, std::size_t limit);
};
constexpr std::array formats{
    Format{".cdr", true, read_cdr},
    Format{".cdrlog", true, read_cdrlog},
    Format{".bin", false, read_kitti},
    Format{".pcd", false, read_pcd},
};

const Format* format_of(const fs::path& path) {
  const auto* const format = std::find_if(formats.begin(), formats.end(),
                                          [&](const Format& f) { return path.extension() == f.extension; });
  return format == formats.end() ? nullptr : format;
}

tl::unexpected<Error> fail_on(const fs::path& path, Errc code, std::string_view what) {
  return fail(code, fmt::format("{}: {}", path.native(), what));
}

Result<Bytes> read_file(const fs::path& path) {
  const core::FileDescriptor file(
      open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // does not wait for the writer of a pipe
  struct stat status {};
  if (!file || fstat(file.get(), &status) != 0) {
    return fail_on(path, errno == EACCES ? Errc::no_permission : Errc::unavailable, std::strerror(errno));
  }
  if (!S_ISREG(status.st_mode))
    return fail_on(path, Errc::invalid_argument, "neither a file nor a directory");
  if (static_cast<std::uint64_t>(status.st_size) > memory_max) {
    return fail_on(path, Errc::limit_exceeded,
                   fmt::format("larger than {}; give a part of it", tool::aligned_bytes_text(memory_max)));
  }
  Bytes bytes(static_cast<std::size_t>(status.st_size));
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = read(file.get(), bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail_on(path, Errc::system, std::strerror(errno));
    if (n == 0) return fail_on(path, Errc::malformed, "it became shorter while it was read");
    done += static_cast<std::size_t>(n);
  }
  return bytes;
}

Result<std::vector<InputCloud>> read_clouds(const fs::path& path, std::size_t limit) {
  const Format* format = format_of(path);
  if (format == nullptr) {
    return fail_on(path, Errc::invalid_argument,
                   "of unknown format; give a .cdr, .cdrlog, .bin (KITTI) or .pcd file");
  }
  const Result<Bytes> bytes = read_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  auto clouds = format->read(*bytes, limit);
  if (!clouds) return fail_on(path, clouds.error().code, clouds.error().message);
  return clouds;
}

struct Listing {
  std::vector<fs::path> files;
  std::vector<std::string> notes;
};

Result<Listing> list(const fs::path& directory) {
  std::error_code error;
  fs::directory_iterator entries(directory, error);
  if (error) return fail_on(directory, Errc::unavailable, error.message());
  Listing listing;
  std::size_t compressed = 0;
  for (const fs::directory_entry& entry : entries) {
    if (entry.path().extension() == ".xz") ++compressed;
    if (format_of(entry.path()) != nullptr && entry.is_regular_file(error))
      listing.files.push_back(entry.path());
  }
  std::sort(listing.files.begin(), listing.files.end());
  if (compressed != 0) {
    listing.notes.push_back(fmt::format("{} compressed file{} (.xz) not used: unpack with xz -dk", compressed,
                                        compressed == 1 ? "" : "s"));
  }
  const bool encoded = std::any_of(listing.files.begin(), listing.files.end(),
                                   [](const fs::path& file) { return format_of(file)->encoded; });
  const std::size_t others =
      encoded ? std::erase_if(listing.files, [](const fs::path& file) { return !format_of(file)->encoded; })
              : 0;
  if (others != 0) {
    listing.notes.push_back(fmt::format("{} .bin or .pcd file{} not used: encoded messages are there too",
                                        others, others == 1 ? "" : "s"));
  }
  if (listing.files.empty()) {
    return fail_on(directory, Errc::unavailable,
                   "no .cdr, .cdrlog, .bin (KITTI) or .pcd file in this directory");
  }
  return listing;
}

std::string name_files(const std::vector<fs::path>& files, std::size_t used) {
  std::string text = "read " + files.front().filename().native();
  if (used > 1) text += fmt::format(" to {} ({} files)", files[used - 1].filename().native(), used);
  if (used < files.size()) text += fmt::format(", which is enough: {} more not used", files.size() - used);
  return text;
}

}  // namespace

Result<Input> read_point_clouds(const fs::path& path, std::size_t clouds_max) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (error || !fs::exists(status)) return fail_on(path, Errc::unavailable, "no such file or directory");
  Listing listing{{path}, {}};
  if (fs::is_directory(status)) {
    Result<Listing> listed = list(path);
    if (!listed) return tl::unexpected(listed.error());
    listing = std::move(*listed);
  }
  Input input;
  std::size_t bytes = 0;
  std::size_t used = 0;
  for (; used < listing.files.size() && input.clouds.size() < clouds_max && bytes < memory_max; ++used) {
    auto clouds = read_clouds(listing.files[used], clouds_max - input.clouds.size());
    if (!clouds) return tl::unexpected(clouds.error());
    for (InputCloud& cloud : *clouds) {
      bytes += cloud.payload.size();
      input.clouds.push_back(std::move(cloud));
    }
  }
  input.notes.push_back(name_files(listing.files, used));
  input.notes.insert(input.notes.end(), listing.notes.begin(), listing.notes.end());
  return input;
}

}  // namespace sft::demo
