// Hostile bodies of any type under any mask. Nothing is read outside of a body. A body that passes the
// validating walk decodes to its values, shows the same values through a dynamic view, and obeys the
// projection law. A body that does not pass does no harm.
#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <proof.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <stdexcept>
#include <string>

#include "sft/detail/convert.h"
#include "sft/detail/decode.h"
#include "sft/detail/project.h"
#include "sft/detail/type_description.h"
#include "sft/detail/view.h"
#include "sft/dynamic_type.h"
#include "sft/dynamic_view.h"
#include "sft/yaml.h"
#include "tests/fuzz/decoder_input.h"
#include "tests/support/encoded.h"
#include "tests/support/foreign_cdr.h"
#include "tests/support/reference.h"
#include "tests/support/value_tree.h"

namespace sft::test {
namespace {

using namespace detail;

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

/// A body in memory of exactly the body's size, so that the address sanitizer notices the first byte beyond
/// it.
class Body {
 public:
  Body(const MessageType& type, FieldMask mask, std::span<const std::byte> bytes)
      : type_(type),
        mask_(std::move(mask)),
        bytes_(new std::byte[bytes.size()]),
        index_(type.support->index_slots()) {
    std::copy(bytes.begin(), bytes.end(), bytes_.get());
    state_ = {.body = bytes_.get(),
              .body_bytes = static_cast<std::uint32_t>(bytes.size()),
              .index = index_.data(),
              .mask = &mask_,
              .elements = &elements_};
  }

  bool walk() { return build_index(state_, type_.type(), index_, &end_) == WalkStatus::ok; }
  std::span<const std::byte> walked() const { return {bytes_.get(), end_}; }

  WalkStatus decode_to(OwnedValue& value) const { return decode(state_, type_.type(), value.get()); }

  /// Decodes a body that passed the walk. Returns nothing if a sequence of structs has a huge length although
  /// its elements have no bytes.
  std::optional<OwnedValue> decoded() const {
    OwnedValue value = type_.make();
    const WalkStatus status = decode_to(value);
    require(status == WalkStatus::ok || status == WalkStatus::bad_length,
            "what passed the walk can be decoded");
    return status == WalkStatus::ok ? std::optional(value) : std::nullopt;
  }

  const SampleState& state() const { return state_; }
  std::vector<std::uint32_t>& index() { return index_; }
  const FieldMask& mask() const { return mask_; }
  const MessageType& type() const { return type_; }

 private:
  const MessageType& type_;
  FieldMask mask_;
  std::unique_ptr<std::byte[]> bytes_;
  std::vector<std::uint32_t> index_;
  ElementIndex elements_;
  SampleState state_{};
  std::uint32_t end_ = 0;
};

/// Returns the type as parsed from its description. A program that was not compiled with the type has it in
/// this form.
const StructType& parsed(const MessageType& type) {
  static std::map<const TypeSupport*, DynamicType> types;
  const auto known = types.find(type.support);
  if (known != types.end()) return known->second.type();
  return types.emplace(type.support, DynamicType::parse(describe(type.type())).value()).first->second.type();
}

void check_dynamic_view(const Body& body, const OwnedValue& value) {
  require(value_tree(DynamicView(body.state(), parsed(body.type()))) == value_tree(value, body.mask()),
          "a dynamic view has the values that were decoded");
}

void check_encoding(const Body& body, const OwnedValue& value) {
  require(reference::is_cdr_of(body.walked(), value, body.mask()), "what was decoded stands in the body");
  const Encoded again(value.type(), value.get(), body.mask());
  require(again.bytes() == reference::cdr(value, body.mask()),
          "encoding it gives the bytes of the projected type");
  Body second(body.type(), body.mask(), again.bytes());
  require(second.walk() && second.walked().size() == again.bytes().size(),
          "what was encoded passes the walk");
  require(std::equal(second.index().begin(), second.index().end(), again.state().index),
          "and has the encoder's index");
  const std::optional<OwnedValue> decoded = second.decoded();
  require(decoded && same_value(*decoded, value), "decoding it gives the same value");
}

std::optional<std::vector<std::byte>> projected(const Body& body, const FieldMask& mask) {
  Projection projection;
  if (!projection.project(body.state(), body.type().type(), mask)) return std::nullopt;
  std::vector<std::byte> bytes;
  for (const Segment& s : projection.segments()) bytes.insert(bytes.end(), s.data, s.data + s.bytes);
  require(bytes.size() == projection.bytes(), "the segments have as many bytes as is said");
  return bytes;
}

void check_projection(const Body& body, const OwnedValue& value, const FieldMask& mask) {
  const auto bytes = projected(body, mask);
  require(bytes.has_value(), "a valid body can be projected");
  Body narrower(body.type(), mask, *bytes);
  require(narrower.walk(), "the projection is valid");
  const std::optional<OwnedValue> decoded = narrower.decoded();
  OwnedValue expected = body.type().make();
  reference::project(value, mask, expected);
  require(!decoded || same_value(*decoded, expected), "the projection law");
  require(reference::is_cdr_of(*bytes, value, mask), "the projection is the CDR of the projected type");
}

/// Walks to every member as views do. The body need not have passed the validating walk.
void skip_through(const SampleState& s, const StructType& type, std::size_t leaf, std::uint64_t offset,
                  int depth) {
  for (std::size_t i = 0; i < type.members.size(); ++i) {
    const Member& m = type.members[i];
    const std::size_t member_leaf = leaf + leaf_offset(type, i);
    const std::uint32_t begin = member_begin(s, type, i, leaf, offset);
    if (begin == no_offset) return;
    require(begin <= s.body_bytes, "members begin within the body");
    if (m.kind != Kind::structure || depth == 0 || !s.mask->any_of(member_leaf, leaf_count(m))) continue;
    const bool is_sequence = m.shape == Shape::sequence;
    const Extent elements = is_sequence ? checked_length(s, begin) : Extent{begin, m.count};
    std::uint32_t at = elements.first;
    for (std::uint32_t n = 0; n < std::min(elements.count, 8U) && at != no_offset; ++n) {
      skip_through(s, *m.type, member_leaf + (is_sequence ? 1 : 0), at, depth - 1);
      at = skip(s, *m.type, member_leaf + (is_sequence ? 1 : 0), at);
    }
  }
}

std::size_t sum(std::string_view text) {
  return text.empty() ? 0 : static_cast<std::size_t>(text.front() + text.back());
}

template <class E>
std::size_t sum(std::span<const E> block) {
  E ends{};
  if (!block.empty()) std::memcpy(&ends, &block.back(), sizeof ends);
  return block.size() + static_cast<std::size_t>(ends == E{});
}

/// Visits elements of ranges, some of them out of order. Visits at most a fixed number, because elements
/// without bytes may have any count.
class Visits {
 public:
  template <class Range, class Visit>
  void each(const std::optional<Range>& range, Visit visit) {
    if (!range) return;
    for (auto at = range->end(); at != range->begin() && left_ > 0;) {
      --left_;
      at -= (at - range->begin() + 1) / 2;
      visit(*at);
    }
    for (auto at = range->begin(); at != range->end() && left_ > 0; ++at) {
      --left_;
      visit(*at);
    }
  }

 private:
  std::uint32_t left_ = 1000;
};

std::size_t read_all(const SampleState& s, const sensor_msgs::msg::PointCloud2*) {
  const auto view = view_of<sensor_msgs::msg::PointCloud2, recorded>(s);
  std::size_t seen = sum(view.header().frame_id().value_or("")) + view.height().value_or(0);
  if (const auto data = view.data()) seen += sum(*data);
  Visits().each(view.fields(), [&](const auto& field) {
    seen += sum(field.name().value_or("")) + field.count().value_or(0);
  });
  return seen + view.is_dense().value_or(false);
}

std::size_t read_all(const SampleState& s, const proof::Scene*) {
  const auto view = view_of<proof::Scene, recorded>(s);
  std::size_t seen =
      sum(view.best().label().value_or("")) + static_cast<std::size_t>(view.stamp().value_or(0));
  Visits visits;
  visits.each(view.tracks(), [&](const auto& track) {
    if (const auto flags = track.flags()) seen += sum(*flags);
    visits.each(track.tags(), [&](std::string_view tag) { seen += sum(tag); });
    visits.each(track.pairs(),
                [&](const auto& pair) { seen += pair.a().value_or(0) + (pair.b() == 0.0 ? 1 : 0); });
    seen += static_cast<std::size_t>(track.mark().value_or('\0'));
  });
  return seen + view.tail().value_or(0);
}

/// Calls the getters of views of a few types, which together have all kinds of getters.
void read_views(const Body& body) {
  volatile std::size_t seen = 0;
  if (&body.type().type() == &TypeTable<sensor_msgs::msg::PointCloud2>::type) {
    seen = read_all(body.state(), static_cast<const sensor_msgs::msg::PointCloud2*>(nullptr));
  } else if (&body.type().type() == &TypeTable<proof::Scene>::type) {
    seen = read_all(body.state(), static_cast<const proof::Scene*>(nullptr));
  }
  static_cast<void>(seen);
}

/// Simulates another process that writes to the chunk after the body and the index were checked.
void survive_anything(Body& body, const FieldMask& narrower) {
  const std::span<const std::byte> bytes(body.state().body, body.state().body_bytes);
  for (std::size_t slot = 0; slot < body.index().size() && !bytes.empty(); ++slot) {
    const auto value = std::to_integer<std::uint32_t>(bytes[slot * 7 % bytes.size()]);
    body.index()[slot] = value > 250 ? no_offset - (value - 250) : value;
  }
  read_views(body);
  static_cast<void>(to_yaml(DynamicView(body.state(), parsed(body.type())),
                            {.elements_max = 4, .output_bytes_max = 10'000}));
  projected(body, narrower);
  OwnedValue value = body.type().make();
  static_cast<void>(body.decode_to(value));
  skip_through(body.state(), body.type().type(), 0, 0, 3);
}

std::optional<std::vector<std::byte>> converted(const StructType& type, std::span<const std::byte> payload) {
  const Result<Payload> parsed = detail::parse_payload(payload);
  if (!parsed) return std::nullopt;
  const ConvertedSize size = converted_size(*parsed, type);
  if (size.status != WalkStatus::ok) return std::nullopt;
  require(size.bytes <= payload.size() * 3 / 2, "conversion adds padding only");
  const std::unique_ptr<std::byte[]> body(new std::byte[size.bytes]);
  require(convert(*parsed, type, {body.get(), size.bytes}) == WalkStatus::ok,
          "what was counted can be written");
  return std::vector(body.get(), body.get() + size.bytes);
}

/// Converts the same bytes from each foreign encoding.
void convert_all(const MessageType& type, std::span<const std::byte> bytes) {
  for (const ForeignEncoding& encoding : foreign_encodings().subspan(1, 3)) {
    const auto converted_bytes = converted(type.type(), foreign_payload(bytes, encoding));
    if (!converted_bytes) continue;
    Body body(type, type.support->full(), *converted_bytes);
    if (!body.walk()) continue;  // the body may be invalid; for instance, a boolean may be neither 0 nor 1
    require(body.walked().size() == converted_bytes->size(), "nothing is left over");
    const std::optional<OwnedValue> value = body.decoded();
    if (!value) continue;
    check_encoding(body, *value);
    require(converted(type.type(), foreign_payload(foreign_cdr(*value, encoding), encoding)) ==
                reference::cdr(*value, body.mask()),
            "the foreign bytes of a value become its bytes");
  }
}

void run(const DecoderInput& input) {
  // uses the input's own encapsulation, if it has one
  static_cast<void>(converted(input.type->type(), input.body));
  convert_all(*input.type, input.body);
  Body body(*input.type, input.mask, input.body);
  skip_through(body.state(), input.type->type(), 0, 0, 3);
  if (body.walk()) {
    require(skip(body.state(), input.type->type(), 0, 0) == body.walked().size(),
            "skipping ends where the walk ended");
    read_views(body);
    require(!body.state().is_malformed(), "what passed the walk is not malformed");
    if (const std::optional<OwnedValue> value = body.decoded()) {
      check_encoding(body, *value);
      check_dynamic_view(body, *value);
      check_projection(body, *value, input.narrower);
    }
  }
  survive_anything(body, input.narrower);
}

}  // namespace
}  // namespace sft::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = sft::test::parse_decoder_input(std::as_bytes(std::span(data, size)));
  if (input) sft::test::run(*input);
  return 0;
}
