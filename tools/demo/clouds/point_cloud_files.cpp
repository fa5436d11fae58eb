#include "tools/demo/clouds/point_cloud_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/sample_format.h"
#include "sft/detail/walk.h"
#include "sft/dynamic_view.h"
#include "sft/type_support.h"

namespace sft::demo {

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

constexpr std::uintmax_t cloud_bytes_max = 16 * 1024 * 1024;  // the largest sample of a publisher by default
constexpr std::size_t memory_max = 1024 * 1024 * 1024;        // of all clouds, which are kept

tl::unexpected<Error> fail_on(const fs::path& path, Errc code, std::string_view what) {
  return fail(code, fmt::format("{}: {}", path.native(), what));
}

/// The size of the cloud. Bytes of another type may have the shape of a PointCloud2, but their figures
/// contradict each other.
Result<std::string> shape_of(const Bytes& payload) {
  const auto expected = std::as_bytes(std::span(detail::encapsulation_cdr_le)).first(2);
  if (payload.size() < detail::encapsulation_bytes ||
      !std::equal(expected.begin(), expected.end(), payload.begin())) {
    return fail(Errc::malformed, "it does not begin with 00 01, as messages in little-endian CDR do");
  }
  const std::span<const std::byte> body = std::span(payload).subspan(detail::encapsulation_bytes);
  const TypeSupport& type = type_support<sensor_msgs::msg::PointCloud2>();
  const FieldMask mask = type.full();
  std::vector<std::uint32_t> index(type.index_slots());
  const detail::SampleState state{.body = body.data(),
                                  .body_bytes = static_cast<std::uint32_t>(body.size()),
                                  .index = index.data(),
                                  .mask = &mask};
  const bool is_whole = detail::build_index(state, type.type(), index) == detail::WalkStatus::ok;
  const DynamicView cloud(state, type.type());
  const auto number = [&](const char* name) { return cloud[name].as<std::uint64_t>().value_or(0); };
  const std::uint64_t height = number("height");
  const std::uint64_t width = number("width");
  const std::uint64_t row_bytes = number("row_step");
  if (!is_whole || row_bytes < width * number("point_step") ||
      height * row_bytes != cloud["data"].size().value_or(0)) {
    return fail(Errc::malformed, "not a sensor_msgs/PointCloud2, or damaged; give a file of one cloud");
  }
  return fmt::format("{} x {} points", height, width);
}

Result<Bytes> read_file(const fs::path& path) {
  std::error_code error;
  if (path.extension() != ".cdr" || !fs::is_regular_file(path, error))
    return fail(Errc::invalid_argument,
                "neither a file .cdr, which has one message, nor a directory of them");
  if (fs::file_size(path, error) > cloud_bytes_max)
    return fail(Errc::limit_exceeded, "larger than 16 MiB; give a smaller cloud");
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(Errc::unavailable, "it cannot be read");
  Bytes bytes;
  std::transform(std::istreambuf_iterator<char>(file), {}, std::back_inserter(bytes),
                 [](char c) { return std::byte(c); });
  return bytes;
}

Result<std::vector<fs::path>> list(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return fail_on(path, Errc::unavailable, "no such file or directory");
  if (!fs::is_directory(path, error)) return std::vector{path};
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension() == ".cdr") files.push_back(entry->path());
  }
  if (error) return fail_on(path, Errc::unavailable, error.message());
  if (files.empty()) return fail_on(path, Errc::unavailable, "no .cdr file in this directory");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

Result<Clouds> read_point_clouds(const fs::path& path, std::size_t clouds_max) {
  const Result<std::vector<fs::path>> files = list(path);
  if (!files) return tl::unexpected(files.error());
  Clouds clouds{.name = path.native(), .shape = {}};
  std::size_t bytes = 0;
  for (const fs::path& file : *files) {
    if (clouds.payloads.size() >= clouds_max || bytes > memory_max) break;
    Result<Bytes> payload = read_file(file);
    const Result<std::string> shape = payload ? shape_of(*payload) : tl::unexpected(payload.error());
    if (!shape) return fail_on(file, shape.error().code, shape.error().message);
    const bool alike = clouds.payloads.empty() || clouds.shape == *shape;
    clouds.shape = alike ? *shape : "several sizes";
    bytes += payload->size();
    clouds.payloads.push_back(std::move(*payload));
  }
  return clouds;
}

}  // namespace sft::demo
