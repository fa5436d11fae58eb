// Files of the Point Cloud Library, version 0.7: a header of text lines, then the points as text or as they
// lie in memory. Compressed files are refused, with the command that converts them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <string_view>

#include "tools/demo/clouds/file_formats.h"
#include "tools/terminal/units.h"

namespace sft::demo {

namespace {

using sensor_msgs::msg::PointField;
using Words = std::vector<std::string_view>;
using Bytes = std::vector<std::byte>;

constexpr std::size_t fields_max = 64;
constexpr std::uint32_t count_max = 65'536;  // numbers in one field, such as a histogram

/// Returns the first word of the text, and removes it from the text; empty at the end of the text.
std::string_view next_word(std::string_view& text) {
  constexpr std::string_view blanks = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(blanks));
  text.remove_prefix(word.size());
  return word;
}

template <class Number>
bool parse(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

template <class Number>
bool append_number(std::string_view text, Bytes& data) {
  Number value{};
  if (!parse(text, value)) return false;
  const auto* begin = reinterpret_cast<const std::byte*>(&value);
  data.insert(data.end(), begin, begin + sizeof value);
  return true;
}

/// A type of numbers in PCD and in sensor_msgs/PointField, and the function that reads a number from text.
struct NumberType {
  char letter;  // F float, I signed, U unsigned
  std::uint32_t size;
  std::uint8_t datatype;
  bool (*append)(std::string_view text, Bytes& data);
};
constexpr std::array number_types{
    NumberType{'F', 4, PointField::FLOAT32, append_number<float>},
    NumberType{'F', 8, PointField::FLOAT64, append_number<double>},
    NumberType{'I', 1, PointField::INT8, append_number<std::int8_t>},
    NumberType{'I', 2, PointField::INT16, append_number<std::int16_t>},
    NumberType{'I', 4, PointField::INT32, append_number<std::int32_t>},
    NumberType{'U', 1, PointField::UINT8, append_number<std::uint8_t>},
    NumberType{'U', 2, PointField::UINT16, append_number<std::uint16_t>},
    NumberType{'U', 4, PointField::UINT32, append_number<std::uint32_t>},
};

struct Field {
  std::string_view name;
  const NumberType* type;
  std::uint32_t count;
  std::uint32_t offset;
};

/// The lines of the header by their names, and the rest of the file behind it.
struct Lines {
  std::map<std::string_view, Words> values;
  std::string_view points;
};

Result<Lines> split_header(std::string_view file) {
  constexpr std::array known{"FIELDS", "SIZE",   "TYPE", "COUNT",   "WIDTH",
                             "HEIGHT", "POINTS", "DATA", "VERSION", "VIEWPOINT"};
  Lines lines;
  for (std::size_t end = 0; (end = file.find('\n')) != file.npos && !lines.values.contains("DATA");) {
    std::string_view line = file.substr(0, end);
    file.remove_prefix(end + 1);
    const std::string_view name = next_word(line);
    if (name.empty() || name.starts_with('#')) continue;
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      return fail(Errc::malformed,
                  fmt::format("its header has an unknown line \"{}\": not a PCD file of version 0.7?", name));
    }
    Words& words = lines.values[name];
    words.clear();
    for (std::string_view word; !(word = next_word(line)).empty();) words.push_back(word);
  }
  lines.points = file;
  if (lines.values.contains("DATA")) return lines;
  return fail(Errc::malformed, "its header ends before the line DATA: truncated, or not a PCD file?");
}

/// Reads the values of a header one after the other. Only the first error is kept; after that all are zero.
class HeaderReader {
 public:
  explicit HeaderReader(const Lines& lines) : lines_(lines) {}

  bool has(std::string_view line) const { return lines_.values.contains(line); }
  /// Returns the words of a line; empty if there is no such line. `fields`: the number of words that it must
  /// have.
  Words words(std::string_view line, std::optional<std::size_t> fields = {}) {
    if (!has(line)) return {};
    const Words& words = lines_.values.at(line);
    if (fields && words.size() != *fields) {
      refuse(fmt::format("line {} of its header has {} values for {} fields", line, words.size(), *fields));
      return {};
    }
    return words;
  }
  std::uint32_t number(std::string_view line, std::string_view text) {
    std::uint32_t value = 0;
    if (!parse(text, value))
      refuse(fmt::format("line {} of its header has \"{}\" where a number is expected", line, text));
    return value;
  }
  std::uint32_t number(std::string_view line) {
    const Words words = this->words(line);
    return has(line) ? number(line, words.empty() ? std::string_view() : words[0]) : 0;
  }
  void refuse(std::string text, Errc code = Errc::malformed) {
    if (!error_) error_ = Error{code, std::move(text)};
  }
  const std::optional<Error>& error() const { return error_; }

 private:
  const Lines& lines_;
  std::optional<Error> error_;
};

const NumberType* type_of(HeaderReader& reader, std::string_view field, std::string_view letter,
                          std::uint32_t size) {
  if (letter != "F" && letter != "I" && letter != "U")
    reader.refuse(fmt::format("its header has a field of unknown type \"{}\"", letter));
  if (size != 1 && size != 2 && size != 4 && size != 8)
    reader.refuse(fmt::format("its header has a field with numbers of {} bytes", size));
  const auto* const type =
      std::find_if(number_types.begin(), number_types.end(), [&](const NumberType& candidate) {
        return letter == std::string_view(&candidate.letter, 1) && size == candidate.size;
      });
  if (type != number_types.end()) return type;
  reader.refuse(fmt::format("its field {} is of type {} with {} bytes, which point clouds do not have", field,
                            letter, size));
  return number_types.begin();
}

std::vector<Field> fields_of(HeaderReader& reader) {
  const Words names = reader.words("FIELDS");
  if (reader.has("FIELDS") && (names.empty() || names.size() > fields_max))
    reader.refuse(fmt::format("its header names {} fields", names.size()));
  const Words sizes = reader.words("SIZE", names.size());
  const Words types = reader.words("TYPE", names.size());
  const Words counts = reader.words("COUNT", names.size());
  if (sizes.empty() || types.empty()) reader.refuse("its header lacks SIZE or TYPE");

  std::vector<Field> fields;
  std::uint32_t offset = 0;
  for (std::size_t i = 0; i < names.size() && !reader.error(); ++i) {
    const std::uint32_t count = counts.empty() ? 1 : reader.number("COUNT", counts[i]);
    if (count == 0 || count > count_max)
      reader.refuse(fmt::format("its header has a field of {} numbers", count));
    const NumberType* type = type_of(reader, names[i], types[i], reader.number("SIZE", sizes[i]));
    fields.push_back({names[i], type, count, offset});
    offset += type->size * count;
  }
  return fields;
}

std::string_view storage_of(HeaderReader& reader) {
  const Words words = reader.words("DATA");
  const std::string_view storage = words.empty() ? std::string_view() : words[0];
  if (storage == "binary_compressed") {
    reader.refuse(
        "its points are compressed (DATA binary_compressed), which the demo does not read; "
        "convert it with: pcl_convert_pcd_ascii_binary IN.pcd OUT.pcd 1");
  } else if (storage != "ascii" && storage != "binary") {
    reader.refuse(fmt::format("its points are stored in an unknown way, DATA \"{}\"", storage));
  }
  return storage;
}

struct Shape {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t point_bytes = 0;
  std::uint64_t points() const { return std::uint64_t{width} * height; }
};

Shape shape_of(HeaderReader& reader, const std::vector<Field>& fields) {
  if (!reader.has("FIELDS") || !reader.has("WIDTH") || !reader.has("HEIGHT"))
    reader.refuse("its header lacks FIELDS, WIDTH or HEIGHT");
  Shape shape{.width = reader.number("WIDTH"), .height = reader.number("HEIGHT")};
  const std::uint32_t points = reader.number("POINTS");
  if (reader.has("POINTS") && points != shape.points()) {
    reader.refuse(fmt::format("its header has POINTS {}, but WIDTH {} times HEIGHT {}", points, shape.width,
                              shape.height));
  }
  for (const Field& field : fields) shape.point_bytes += field.type->size * field.count;
  // This also bounds what is allocated for the points.
  if (shape.point_bytes > 0 && shape.points() > cloud_bytes_max / shape.point_bytes) {
    reader.refuse(fmt::format("its {} points of {} bytes are more than a sample may have ({})",
                              tool::grouped_count_text(shape.points()), shape.point_bytes,
                              tool::aligned_bytes_text(static_cast<double>(cloud_bytes_max))),
                  Errc::limit_exceeded);
  }
  return shape;
}

Result<Bytes> numbers_from_text(std::string_view text, const Shape& shape, const std::vector<Field>& fields) {
  Bytes data;
  for (std::uint64_t point = 0; point < shape.points(); ++point) {
    for (const Field& field : fields) {
      for (std::uint32_t n = 0; n < field.count; ++n) {
        const std::string_view word = next_word(text);
        if (word.empty())
          return fail(Errc::malformed, "it has fewer points than its header says: truncated?");
        if (field.type->append(word, data)) continue;
        return fail(Errc::malformed, fmt::format("it has \"{}\" where a number for field {} is expected",
                                                 word.substr(0, 40), field.name));
      }
    }
  }
  if (!next_word(text).empty()) return fail(Errc::malformed, "it has more points than its header says");
  return data;
}

Result<Bytes> numbers_from_memory(std::string_view bytes, const Shape& shape) {
  // Some writers align the length of the file, so it may be longer.
  const std::uint64_t wanted = shape.points() * shape.point_bytes;
  if (bytes.size() < wanted) {
    return fail(Errc::malformed, fmt::format("it has {} bytes of points, its header says {}: truncated?",
                                             bytes.size(), wanted));
  }
  const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
  return Bytes(begin, begin + wanted);
}

}  // namespace

Result<std::vector<InputCloud>> read_pcd(std::span<const std::byte> file, std::size_t /*limit*/) {
  const auto lines = split_header({reinterpret_cast<const char*>(file.data()), file.size()});
  if (!lines) return tl::unexpected(lines.error());
  HeaderReader reader(*lines);
  const std::string_view storage = storage_of(reader);
  const std::vector<Field> fields = fields_of(reader);
  const Shape shape = shape_of(reader, fields);
  if (reader.error()) return tl::unexpected(*reader.error());

  const auto data = storage == "ascii" ? numbers_from_text(lines->points, shape, fields)
                                       : numbers_from_memory(lines->points, shape);
  if (!data) return tl::unexpected(data.error());
  std::vector<PointField> point_fields;
  for (const Field& field : fields) {
    if (field.name == "_") continue;  // padding
    point_fields.push_back(point_field(field.name, field.offset, field.type->datatype, field.count));
  }
  return convert(shape.height, shape.width, shape.point_bytes, std::move(point_fields), *data);
}

}  // namespace sft::demo
