// Hostile messages of the types that have parts, under any selection. The input is u8 number of the type
// (modulo their count), u8 length of a selection as text, the text, and the body of a whole message. Nothing
// is read outside of the body. If the message passes the validating walk, the part taken from it is a
// message, too. Points and cells are read from both, and conditions are evaluated.
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <optional>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/seam/gate.h"
#include "sft/cells.h"
#include "sft/detail/project.h"
#include "sft/detail/view.h"
#include "sft/dynamic_view.h"
#include "sft/points.h"
#include "sft/type_support.h"

namespace sft {
namespace {

using sensor_msgs::msg::PointCloud2;

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

/// A body in memory of exactly the body's size, so that the address sanitizer notices the first byte beyond
/// it.
class Body {
 public:
  Body(const TypeSupport& type, FieldMask mask, std::size_t bytes)
      : type_(type),
        mask_(std::move(mask)),
        bytes_(bytes),
        body_(new std::byte[bytes]),
        index_(type.index_slots()) {
    state_ = {.body = body_.get(),
              .body_bytes = static_cast<std::uint32_t>(bytes),
              .index = index_.data(),
              .mask = &mask_};
  }
  std::byte* data() { return body_.get(); }
  /// Returns the end of the message, in bytes; nothing if the bytes are no message.
  std::optional<std::uint32_t> walk() {
    std::uint32_t end = 0;
    if (detail::build_index(state_, type_.type(), index_, &end) != detail::WalkStatus::ok)
      return std::nullopt;
    return end;
  }
  const detail::SampleState& state() const { return state_; }
  std::size_t bytes() const { return bytes_; }

 private:
  const TypeSupport& type_;
  const FieldMask mask_;
  const std::size_t bytes_;
  const std::unique_ptr<std::byte[]> body_;
  std::vector<std::uint32_t> index_;
  detail::SampleState state_{};
};

/// Evaluates the conditions twice. The second time there may be a former sample to compare with.
void ask(const Selection& selection, const TypeSupport& type, const detail::SampleState& sample) {
  if (selection.gate().conditions.empty()) return;
  const Result<void> sound = detail::Conditions::check(type.type(), selection.gate().conditions);
  require(sound.has_value(), "conditions that a text names can be asked");
  core::Gate gate(0, detail::Conditions(type.type(), selection.gate().conditions), selection.gate_hash());
  gate.reader_begins();
  for (const std::int64_t stamp_ns : {0, 1}) {
    gate.consider(detail::FieldSource::of_sample(sample), stamp_ns);
    gate.made(detail::FieldSource::of_sample(sample), stamp_ns);
  }
}

template <class Cell>
void read_all(const Result<Cells<Cell>>& cells) {
  if (!cells) return;
  if (!cells->empty()) {
    const auto last = (*cells)[cells->size() - 1];
    asm volatile("" : : "m"(last));
  }
  std::size_t left = 10'000;
  for (const auto cell : *cells) {
    asm volatile("" : : "m"(cell));
    if (--left == 0) break;
  }
}

void read_points(const detail::SampleState& cloud) {
  const auto view = detail::view_of<PointCloud2, Req<PointCloud2>(all<PointCloud2>)>(cloud);
  read_all(view.points<float, double, std::uint16_t>("x", "y", "ring"));
}

void read_cells(const TypeSupport& type, const detail::SampleState& sample) {
  const DynamicView message(sample, type.type());
  for (const char* field : {"data", "ranges", "intensities"}) {
    read_all(cells_of<std::uint8_t>(message, field));
    read_all(cells_of<std::array<std::uint8_t, 3>>(message, field));
    read_all(cells_of<std::uint16_t>(message, field));
    read_all(cells_of<float>(message, field));
  }
}

void check(const TypeSupport& type, std::string_view text, std::span<const std::uint8_t> bytes) {
  Body whole(type, type.full(), bytes.size());
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<std::uint8_t*>(whole.data()));
  if (!whole.walk()) return;
  const bool is_cloud = &type == &type_support<PointCloud2>();
  if (is_cloud) read_points(whole.state());
  read_cells(type, whole.state());
  const Result<Selection> selection = type.parse_selection(text);
  if (!selection) return;
  ask(*selection, type, whole.state());
  const detail::ProjectionPlan plan(type, type.closed(*selection));
  detail::Projection projection;
  if (!projection.project(whole.state(), plan)) return;
  Body part(type, plan.mask(), projection.bytes());
  std::byte* to = part.data();
  for (const detail::Segment& segment : projection.segments())
    to = std::copy_n(segment.data, segment.bytes, to);
  require(part.walk() == part.bytes(), "a part is a message, and no more than that");
  if (is_cloud && plan.mask() == type.full()) read_points(part.state());
  read_cells(type, part.state());
}

}  // namespace
}  // namespace sft

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::array types{
      &sft::type_support<sensor_msgs::msg::PointCloud2>(), &sft::type_support<sensor_msgs::msg::Image>(),
      &sft::type_support<nav_msgs::msg::OccupancyGrid>(), &sft::type_support<sensor_msgs::msg::LaserScan>()};
  if (size < 2 || size - 2 < data[1]) return 0;
  const std::string text(reinterpret_cast<const char*>(data + 2), data[1]);
  sft::check(*types[data[0] % types.size()], text, {data + 2 + data[1], size - 2 - data[1]});
  return 0;
}
