#include "tests/pairs/message.h"

#include <algorithm>

#include "sft/detail/sample_format.h"
#include "tests/support/encoded.h"

namespace sft::test {

using namespace detail;
PointCloud2 message(std::uint64_t number) {
  const auto n = static_cast<std::uint32_t>(number);
  PointCloud2 m;
  m.header.stamp.sec = static_cast<std::int32_t>(n);
  m.header.stamp.nanosec = n + 1;
  m.header.frame_id = "lidar " + std::to_string(n);
  m.height = n + 2;
  m.width = n + 3;
  m.fields.resize(1 + n % 3);
  for (auto& field : m.fields) field = {.name = std::to_string(n + 4), .offset = n + 5, .count = n + 6};
  m.is_bigendian = n % 2 == 0;
  m.point_step = n + 7;
  m.row_step = n + 8;
  m.data.resize(2000 + n % 1000);
  for (std::size_t i = 0; i < m.data.size(); ++i) m.data[i] = static_cast<std::uint8_t>(n + i);
  m.is_dense = n % 2 == 1;
  return m;
}

bool is_message(std::uint64_t number, const FieldMask& mask, std::span<const std::byte> cdr) {
  const PointCloud2 m = message(number);
  const std::vector<std::byte> body = Encoded(TypeTable<PointCloud2>::type, &m, mask).bytes();
  return cdr.size() == encapsulation_bytes + body.size() &&
         std::ranges::equal(cdr.first(encapsulation_bytes), std::as_bytes(std::span(encapsulation_cdr_le))) &&
         std::ranges::equal(cdr.subspan(encapsulation_bytes), body);
}

}  // namespace sft::test
