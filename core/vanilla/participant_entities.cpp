#include "core/vanilla/participant_entities.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace sft::core {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

constexpr std::size_t alignment = sizeof(std::uint32_t);
constexpr std::size_t text_bytes_max = 256;

class EntitiesWriter {
 public:
  explicit EntitiesWriter(GuidBytes guid_bytes) : guid_bytes_(static_cast<std::size_t>(guid_bytes)) {}

  void guid(const Guid& guid) {
    add(guid.data(), guid.size());
    bytes_.resize(bytes_.size() + guid_bytes_ - guid.size());
  }
  void count(std::size_t count) {
    bytes_.resize((bytes_.size() + alignment - 1) / alignment * alignment);
    const auto number = static_cast<std::uint32_t>(count);
    add(&number, sizeof number);
  }
  void text(const std::string& text) {
    count(text.size() + 1);
    add(text.c_str(), text.size() + 1);
  }
  void guids(const std::vector<Guid>& guids) {
    count(guids.size());
    for (const Guid& one : guids) guid(one);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void add(const void* from, std::size_t size) {
    const auto* const first = static_cast<const std::byte*>(from);
    bytes_.insert(bytes_.end(), first, first + size);
  }

  const std::size_t guid_bytes_;
  std::vector<std::byte> bytes_;
};

/// Reads values until the bytes end or do not fit the message. After that all results are empty.
class EntitiesReader {
 public:
  EntitiesReader(std::span<const std::byte> body, GuidBytes guid_bytes)
      : body_(body), guid_bytes_(static_cast<std::size_t>(guid_bytes)) {}

  bool fits() const { return fits_; }
  /// Returns true if only padding is left.
  bool is_at_end() const { return fits_ && body_.size() - at_ < alignment; }

  Guid guid() {
    Guid guid{};
    if (const auto bytes = take(guid_bytes_); fits_) std::memcpy(guid.data(), bytes.data(), guid.size());
    return guid;
  }
  std::uint32_t count() {
    take((alignment - at_ % alignment) % alignment);
    std::uint32_t number = 0;
    if (const auto bytes = take(sizeof number); fits_) std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  std::string text() {
    const std::uint32_t size = count();
    fits_ = fits_ && size > 0 && size <= text_bytes_max + 1;
    const auto bytes = take(fits_ ? size : 0);
    if (bytes.empty()) return {};
    fits_ = bytes.back() == std::byte{0};
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size() - 1};
  }
  std::vector<Guid> guids() {
    std::vector<Guid> guids;
    for (std::uint32_t left = count(); left > 0 && fits_; --left) guids.push_back(guid());
    return guids;
  }

 private:
  std::span<const std::byte> take(std::size_t size) {
    fits_ = fits_ && size <= body_.size() - at_;
    if (!fits_) return {};
    const auto bytes = body_.subspan(at_, size);
    at_ += size;
    return bytes;
  }

  const std::span<const std::byte> body_;
  const std::size_t guid_bytes_;
  std::size_t at_ = 0;
  bool fits_ = true;
};

std::optional<ReceivedEntities> decode_as(std::span<const std::byte> body, GuidBytes guid_bytes) {
  EntitiesReader reader(body, guid_bytes);
  ReceivedEntities received{.entities = {.participant = reader.guid()}, .guid_bytes = guid_bytes};
  for (std::uint32_t left = reader.count(); left > 0 && reader.fits(); --left) {
    ParticipantEntities::Node& node = received.entities.nodes.emplace_back();
    node.name_space = reader.text();
    node.name = reader.text();
    node.readers = reader.guids();
    node.writers = reader.guids();
  }
  return reader.is_at_end() ? std::optional(std::move(received)) : std::nullopt;
}

}  // namespace

std::optional<GuidBytes> guid_bytes_of(std::string_view distribution) {
  constexpr std::array<std::string_view, 3> before{"foxy", "galactic", "humble"};
  constexpr std::array<std::string_view, 5> later{"iron", "jazzy", "kilted", "lyrical", "rolling"};
  if (std::ranges::find(before, distribution) != before.end()) return GuidBytes::before_iron;
  if (std::ranges::find(later, distribution) != later.end()) return GuidBytes::as_of_iron;
  return std::nullopt;
}

std::vector<std::byte> encode_entities(const ParticipantEntities& entities, GuidBytes guid_bytes) {
  EntitiesWriter writer(guid_bytes);
  writer.guid(entities.participant);
  writer.count(entities.nodes.size());
  for (const ParticipantEntities::Node& node : entities.nodes) {
    writer.text(node.name_space);
    writer.text(node.name);
    writer.guids(node.readers);
    writer.guids(node.writers);
  }
  return writer.take();
}

std::optional<ReceivedEntities> decode_entities(std::span<const std::byte> body) {
  std::optional<ReceivedEntities> one = decode_as(body, GuidBytes::as_of_iron);
  std::optional<ReceivedEntities> other = decode_as(body, GuidBytes::before_iron);
  if (one && other) return std::nullopt;
  return one ? std::move(one) : std::move(other);
}

}  // namespace sft::core
