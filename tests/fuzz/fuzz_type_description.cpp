// Hostile type descriptions, and hostile bodies of the types that they describe. An accepted description is
// the only description of its type. Bodies that pass the validating walk can be read, printed and projected.
// Other bodies do no harm.
#include <cstring>
#include <memory>
#include <stdexcept>

#include "sft/detail/project.h"
#include "sft/detail/type_description.h"
#include "sft/detail/type_shape.h"
#include "sft/dynamic_type.h"
#include "sft/dynamic_view.h"
#include "sft/json.h"
#include "sft/yaml.h"
#include "tests/fuzz/description_input.h"

namespace sft::test {
namespace {

using namespace detail;

constexpr std::size_t text_bytes_max = 100'000;

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports the exception as a crash
}

/// A body in memory of exactly the body's size, so that the address sanitizer notices the first byte beyond
/// it.
class Body {
 public:
  Body(const TypeSupport& type, FieldMask mask, std::span<const std::byte> bytes)
      : mask_(std::move(mask)), bytes_(new std::byte[bytes.size()]), index_(type.index_slots()) {
    std::copy(bytes.begin(), bytes.end(), bytes_.get());
    state_ = {.body = bytes_.get(),
              .body_bytes = static_cast<std::uint32_t>(bytes.size()),
              .index = index_.data(),
              .mask = &mask_};
  }

  const SampleState& state() const { return state_; }
  SampleState without_index() const {
    SampleState s = state_;
    s.index = nullptr;
    return s;
  }
  std::span<std::uint32_t> index() { return index_; }
  const FieldMask& mask() const { return mask_; }

 private:
  FieldMask mask_;
  std::unique_ptr<std::byte[]> bytes_;
  std::vector<std::uint32_t> index_;
  SampleState state_{};
};

bool is_printed(const Result<std::string>& text) {
  require(!text || text->size() <= 4 * text_bytes_max, "the text is limited");
  return text.has_value() || text.error().code == Errc::limit_exceeded;
}

/// Prints `view`, which has an index, and `walked`, which has none. Returns true if both succeed and give the
/// same texts.
bool print(const DynamicView& view, const DynamicView& walked) {
  const YamlOptions yaml{.elements_max = 10, .units = true, .output_bytes_max = text_bytes_max};
  const JsonOptions json{.elements_max = 10, .bytes_as_base64 = false, .output_bytes_max = text_bytes_max};
  const Result<std::string> texts[]{to_yaml(view, yaml), to_yaml(walked, yaml), to_json(view, json),
                                    to_json(walked, json)};
  bool all = true;
  for (const auto& text : texts) all &= is_printed(text);
  const auto alike = [](const Result<std::string>& a, const Result<std::string>& b) {
    return !a || !b || *a == *b;
  };
  return all && alike(texts[0], texts[1]) && alike(texts[2], texts[3]);
}

void check_type(const DynamicType& type, std::span<const std::byte> description) {
  const std::vector<std::byte> again = describe(type.type());
  require(std::equal(again.begin(), again.end(), description.begin(), description.end()),
          "a type has one description");
  require(type.support().hash() == type.hash(), "and one hash");
  require(!format_shape(type.type()).empty(), "and a shape");
  require(first_difference(type.type(), DynamicType::parse(again)->type()).empty(), "and is like itself");
}

/// Checks the projection to those leaves of the mask that have even numbers.
void check_projection(const DynamicType& type, const Body& body) {
  FieldMask narrower(body.mask().leaves());
  for (std::size_t leaf = 0; leaf < narrower.leaves(); leaf += 2) {
    if (body.mask().contains(leaf)) narrower.insert(leaf);
  }
  narrower = type.support().closed(narrower);
  Projection projection;
  require(projection.project(body.state(), type.type(), narrower), "a valid body can be projected");
  std::vector<std::byte> bytes;
  for (const Segment& s : projection.segments()) bytes.insert(bytes.end(), s.data, s.data + s.bytes);
  Body projected(type.support(), narrower, bytes);
  require(build_index(projected.state(), type.type(), projected.index()) == WalkStatus::ok,
          "and is valid then");
}

/// Checks that a part of each field with a layout can be taken.
void check_parts(const DynamicType& type, const Body& body) {
  const TypeSupport& support = type.support();
  for (const std::size_t leaf : body.mask()) {
    if (support.layout_of(leaf) == nullptr) continue;
    const Selection::Part part{
        .leaf = static_cast<std::uint32_t>(leaf), .rows = {1, 9, 1}, .columns = {0, 8, 2}};
    const Selection asked = support.closed(Selection::make(support.none(), {part}, {}).value());
    require(support.closed(asked) == asked, "a closed selection stays");
    if (!body.mask().contains(asked.mask())) continue;
    Projection projection;
    require(projection.project(body.state(), ProjectionPlan(support, asked)), "a part can be taken");
    std::vector<std::byte> bytes;
    for (const Segment& s : projection.segments()) bytes.insert(bytes.end(), s.data, s.data + s.bytes);
    Body some(support, asked.mask(), bytes);
    require(build_index(some.state(), type.type(), some.index()) == WalkStatus::ok, "and is valid then");
  }
}

void run(std::span<const std::byte> input) {
  auto [description, rest] = parse_description_input(input);
  const Result<DynamicType> type = DynamicType::parse(description);
  if (!type) return require(!type.error().message.empty(), "an error says what is wrong");
  check_type(*type, description);

  Body body(type->support(), type->support().closed(take_mask(rest, type->support().leaves())), rest);
  if (build_index(body.state(), type->type(), body.index()) == WalkStatus::ok) {
    const SampleState without_index = body.without_index();
    require(print({body.state(), type->type()}, {without_index, type->type()}),
            "a valid body can be printed");
    require(!body.state().is_malformed() && !without_index.is_malformed(), "and is not malformed");
    check_projection(*type, body);
    check_parts(*type, body);
  }
  for (std::size_t slot = 0; slot < body.index().size(); ++slot) {  // makes an index with wrong offsets
    const std::size_t at = slot * 7 % (rest.size() + 1);
    body.index()[slot] =
        static_cast<std::uint32_t>(at < rest.size() && rest[at] == std::byte{0xff} ? no_offset - 1 : at);
  }
  const SampleState without_index = body.without_index();
  print({body.state(), type->type()}, {without_index, type->type()});
}

}  // namespace
}  // namespace sft::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sft::test::run(std::as_bytes(std::span(data, size)));
  return 0;
}
