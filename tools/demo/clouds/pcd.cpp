#include "tools/demo/clouds/pcd.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>

namespace sft::demo {

namespace {

using sensor_msgs::msg::PointField;

template <class Number>
bool append_number(std::string_view text, std::vector<std::byte>& data) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return false;
  const std::size_t at = data.size();
  data.resize(at + sizeof value);
  std::memcpy(data.data() + at, &value, sizeof value);
  return true;
}

/// A type of numbers as PCD and as sensor_msgs/PointField call it, and how one is read from text.
struct NumberType {
  char type;
  std::uint32_t size;
  std::uint8_t datatype;
  bool (*append)(std::string_view text, std::vector<std::byte>& data);
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

Result<std::vector<const NumberType*>> types_of(const PcdHeader& header) {
  std::vector<const NumberType*> types;
  for (const PcdField& field : header.fields) {
    const auto* const type =
        std::find_if(number_types.begin(), number_types.end(), [&](const NumberType& candidate) {
          return candidate.type == field.type && candidate.size == field.size;
        });
    if (type == number_types.end()) {
      return fail(Errc::malformed,
                  fmt::format("its field {} is of type {} with {} bytes, which point clouds do not have",
                              field.name, field.type, field.size));
    }
    types.push_back(type);
  }
  return types;
}

std::vector<PointField> point_fields(const PcdHeader& header, const std::vector<const NumberType*>& types) {
  std::vector<PointField> fields;
  std::uint32_t offset = 0;
  for (std::size_t i = 0; i < types.size(); ++i) {
    const PcdField& field = header.fields[i];
    if (field.name != "_")
      fields.push_back(point_field(field.name, offset, types[i]->datatype, field.count));  // "_" pads
    offset += field.size * field.count;
  }
  return fields;
}

/// The words of a text, one after the other; empty at its end.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  std::string_view next() {
    constexpr std::string_view blanks = " \t\r\n";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(blanks), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(blanks));
    rest_.remove_prefix(word.size());
    return word;
  }

 private:
  std::string_view rest_;
};

Result<void> append_point(Words& words, const PcdHeader& header, const std::vector<const NumberType*>& types,
                          std::vector<std::byte>& data) {
  for (std::size_t i = 0; i < types.size(); ++i) {
    for (std::uint32_t n = 0; n < header.fields[i].count; ++n) {
      const std::string_view word = words.next();
      if (word.empty()) return fail(Errc::malformed, "it has fewer points than its header says: truncated?");
      if (!types[i]->append(word, data)) {
        return fail(Errc::malformed, fmt::format("it has \"{}\" where a number for field {} is expected",
                                                 word.substr(0, 40), header.fields[i].name));
      }
    }
  }
  return {};
}

Result<std::vector<std::byte>> numbers_from_text(std::string_view text, const PcdHeader& header,
                                                 const std::vector<const NumberType*>& types) {
  Words words(text);
  std::vector<std::byte> data;
  for (std::uint64_t point = 0; point < header.points(); ++point) {
    if (Result<void> done = append_point(words, header, types, data); !done)
      return tl::unexpected(done.error());
  }
  if (!words.next().empty()) return fail(Errc::malformed, "it has more points than its header says");
  return data;
}

Result<std::vector<std::byte>> numbers_from_memory(std::string_view bytes, const PcdHeader& header) {
  // Some writers align the file's length: more is no harm.
  const std::uint64_t wanted = header.points() * header.point_bytes();
  if (bytes.size() < wanted) {
    return fail(Errc::malformed, fmt::format("it has {} bytes of points, its header says {}: truncated?",
                                             bytes.size(), wanted));
  }
  const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
  return std::vector<std::byte>(begin, begin + wanted);
}

}  // namespace

Result<std::vector<InputCloud>> read_pcd(std::span<const std::byte> file, std::size_t /*limit*/) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  const Result<PcdHeader> header = read_pcd_header(text);
  if (!header) return tl::unexpected(header.error());
  const auto types = types_of(*header);
  if (!types) return tl::unexpected(types.error());
  const std::string_view points = text.substr(header->bytes);
  const auto data = header->storage == PcdHeader::Storage::ascii ? numbers_from_text(points, *header, *types)
                                                                 : numbers_from_memory(points, *header);
  if (!data) return tl::unexpected(data.error());
  return convert(header->height, header->width, header->point_bytes(), point_fields(*header, *types), *data)
      .map([](ConvertedCloud&& cloud) {
        std::vector<InputCloud> clouds;
        clouds.emplace_back(std::move(cloud));
        return clouds;
      });
}

}  // namespace sft::demo
