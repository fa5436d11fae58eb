#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "tools/demo/clouds/pcd.h"
#include "tools/terminal/units.h"

namespace sft::demo {

namespace {

constexpr std::size_t fields_max = 64;
constexpr std::uint32_t count_max = 65'536;  // of numbers in one field, such as a histogram

using Words = std::vector<std::string_view>;

Words split(std::string_view line) {
  constexpr std::string_view blanks = " \t\r";
  Words words;
  for (std::size_t begin = line.find_first_not_of(blanks); begin != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(blanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(blanks, end);
  }
  return words;
}

Result<std::uint32_t> number(std::string_view line_name, std::string_view text) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size()) return value;
  return fail(Errc::malformed,
              fmt::format("line {} of its header has \"{}\" where a number is expected", line_name, text));
}

/// Reads the header line by line; each line is a name and its values.
class HeaderParser {
 public:
  Result<void> take(const Words& words) {
    const std::string_view name = words[0];
    const Words values(words.begin() + 1, words.end());
    if (name == "FIELDS") return take_fields(values);
    if (name == "SIZE" || name == "TYPE" || name == "COUNT") return take_per_field(name, values);
    if (name == "WIDTH" || name == "HEIGHT" || name == "POINTS") return take_number(name, values);
    if (name == "DATA") return take_data(values);
    if (name == "VERSION" || name == "VIEWPOINT") return {};
    return fail(Errc::malformed,
                fmt::format("its header has an unknown line \"{}\": not a PCD file of version 0.7?", name));
  }

  bool complete() const { return complete_; }

  Result<PcdHeader> finish(std::size_t bytes) {
    header_.bytes = bytes;
    if (!has_width_ || !has_height_ || header_.fields.empty()) {
      return fail(Errc::malformed, "its header lacks FIELDS, WIDTH or HEIGHT");
    }
    if (points_ && *points_ != header_.points()) {
      return fail(Errc::malformed, fmt::format("its header has POINTS {}, but WIDTH {} times HEIGHT {}",
                                               *points_, header_.width, header_.height));
    }
    for (const PcdField& field : header_.fields) {
      if (field.size == 0 || field.type == '?') return fail(Errc::malformed, "its header lacks SIZE or TYPE");
    }
    // Also bounds what is allocated for the points.
    if (header_.points() > cloud_bytes_max / header_.point_bytes()) {
      return fail(Errc::limit_exceeded,
                  fmt::format("its {} points of {} bytes are more than a sample may have ({})",
                              tool::grouped_count_text(header_.points()), header_.point_bytes(),
                              tool::aligned_bytes_text(static_cast<double>(cloud_bytes_max))));
    }
    return std::move(header_);
  }

 private:
  Result<void> take_fields(const Words& names) {
    if (names.empty() || names.size() > fields_max) {
      return fail(Errc::malformed, fmt::format("its header names {} fields", names.size()));
    }
    header_.fields.clear();
    for (const std::string_view name : names) header_.fields.push_back({.name = std::string(name)});
    return {};
  }

  Result<void> take_per_field(std::string_view name, const Words& values) {
    if (values.size() != header_.fields.size()) {
      return fail(Errc::malformed, fmt::format("line {} of its header has {} values for {} fields", name,
                                               values.size(), header_.fields.size()));
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (Result<void> set = take_property(header_.fields[i], name, values[i]); !set) return set;
    }
    return {};
  }

  static Result<void> take_property(PcdField& field, std::string_view name, std::string_view value) {
    if (name == "TYPE") {
      if (value != "F" && value != "I" && value != "U") {
        return fail(Errc::malformed, fmt::format("its header has a field of unknown type \"{}\"", value));
      }
      field.type = value[0];
      return {};
    }
    const Result<std::uint32_t> n = number(name, value);
    if (!n) return tl::unexpected(n.error());
    if (name == "COUNT" && (*n == 0 || *n > count_max)) {
      return fail(Errc::malformed, fmt::format("its header has a field of {} numbers", *n));
    }
    if (name == "SIZE" && *n != 1 && *n != 2 && *n != 4 && *n != 8) {
      return fail(Errc::malformed, fmt::format("its header has a field with numbers of {} bytes", *n));
    }
    (name == "SIZE" ? field.size : field.count) = *n;
    return {};
  }

  Result<void> take_number(std::string_view name, const Words& values) {
    const Result<std::uint32_t> n = number(name, values.empty() ? std::string_view() : values[0]);
    if (!n) return tl::unexpected(n.error());
    if (name == "WIDTH") {
      header_.width = *n;
      has_width_ = true;
    } else if (name == "HEIGHT") {
      header_.height = *n;
      has_height_ = true;
    } else {
      points_ = *n;
    }
    return {};
  }

  Result<void> take_data(const Words& values) {
    const std::string_view storage = values.empty() ? std::string_view() : values[0];
    complete_ = true;
    if (storage == "ascii" || storage == "binary") {
      header_.storage = storage == "ascii" ? PcdHeader::Storage::ascii : PcdHeader::Storage::binary;
      return {};
    }
    if (storage == "binary_compressed") {
      return fail(Errc::malformed,
                  "its points are compressed (DATA binary_compressed), which the demo does not read; "
                  "convert it with: pcl_convert_pcd_ascii_binary IN.pcd OUT.pcd 1");
    }
    return fail(Errc::malformed,
                fmt::format("its points are stored in an unknown way, DATA \"{}\"", storage));
  }

  PcdHeader header_;
  bool has_width_ = false;
  bool has_height_ = false;
  std::optional<std::uint32_t> points_;
  bool complete_ = false;
};

}  // namespace

std::uint32_t PcdHeader::point_bytes() const {
  std::uint32_t sum = 0;
  for (const PcdField& field : fields) sum += field.size * field.count;
  return sum;
}

Result<PcdHeader> read_pcd_header(std::string_view file) {
  HeaderParser parser;
  for (std::size_t begin = 0; begin < file.size();) {
    const std::size_t end = file.find('\n', begin);
    if (end == file.npos) break;
    const Words words = split(file.substr(begin, end - begin));
    begin = end + 1;
    if (words.empty() || words[0].starts_with('#')) continue;
    if (Result<void> taken = parser.take(words); !taken) return tl::unexpected(taken.error());
    if (parser.complete()) return parser.finish(begin);
  }
  return fail(Errc::malformed, "its header ends before the line DATA: truncated, or not a PCD file?");
}

}  // namespace sft::demo
