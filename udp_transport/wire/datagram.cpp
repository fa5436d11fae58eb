#include "udp_transport/wire/datagram.h"

#include <concepts>
#include <cstring>
#include <type_traits>

namespace sft::udp {

namespace {

// The offsets of header fields. The first ones are common to several kinds of datagrams, the later ones are
// those of particular kinds.
constexpr std::size_t at_kind = 0, at_flags = 1, at_variant = 2, at_writer = 4, at_sequence = 8;
constexpr std::size_t at_total = 12, at_stamp = 16, at_mask = 24;
constexpr std::size_t at_near_variant = 1, at_near_writer = 2, at_near_sequence = 6, at_near_offset = 10;
constexpr std::size_t at_far_offset = 12;
constexpr std::size_t at_samples = 12, at_bytes_each = 14;
constexpr std::size_t at_short_ordinal = 12;
constexpr std::size_t at_single_stamp = 12, at_single_mask = 20;
// The bit positions of flags and numbers in the first 32 bits of a whole datagram.
constexpr unsigned words_bit = 8, merged_bit = 9, narrow_bit = 10, short_variant_bit = 11;
constexpr unsigned short_channel_bit = 21;
static_assert(whole_variants_end == 1U << (short_channel_bit - short_variant_bit) &&
              whole_channels_end == 1U << (32 - short_channel_bit));
constexpr std::size_t at_count = 2;  // offset of the number of missing parts in an ack

template <std::unsigned_integral T>
void store(T value, std::byte* out) noexcept {
  for (std::size_t i = 0; i < sizeof(T); ++i) out[i] = static_cast<std::byte>(value >> (8 * i));
}

template <std::unsigned_integral T>
T load(const std::byte* from) noexcept {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= static_cast<T>(static_cast<T>(from[i]) << (8 * i));
  return value;
}

void store_kind(DatagramKind kind, std::uint8_t flags, std::byte* out) noexcept {
  store(static_cast<std::uint8_t>(wire_version << 4 | static_cast<std::uint8_t>(kind)), out + at_kind);
  store(flags, out + at_flags);
}

void store_common(DatagramKind kind, std::uint8_t flags, const SampleLabel& label, std::byte* out) noexcept {
  store_kind(kind, flags, out);
  store(label.variant, out + at_variant);
  store(label.writer, out + at_writer);
  store(label.sequence, out + at_sequence);
}

/// Returns the kind of the datagram; empty if the bytes are no datagram of this version.
std::optional<DatagramKind> kind_of_bytes(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() < following_header_bytes || bytes.size() > datagram_bytes_max) return {};
  const auto version_and_kind = load<std::uint8_t>(&bytes[at_kind]);
  if (version_and_kind >> 4 != wire_version) return {};
  const auto kind = static_cast<DatagramKind>(version_and_kind & 0xf);
  if (kind < DatagramKind::first || kind > DatagramKind::far) return {};
  return kind;
}

SampleLabel load_label(const std::byte* from) noexcept {
  return {.writer = load<std::uint32_t>(from + at_writer),
          .sequence = load<std::uint32_t>(from + at_sequence),
          .variant = load<std::uint16_t>(from + at_variant)};
}

/// Stores the mask in two or eight bytes.
void store_mask(std::uint64_t mask, std::byte* out) noexcept {
  if (is_narrow(mask)) return store(static_cast<std::uint16_t>(mask), out);
  store(mask, out);
}

std::uint8_t width_flag(std::uint64_t mask) noexcept { return is_narrow(mask) ? narrow_mask : 0; }

/// Returns the mask; empty if the datagram ends before the mask does, or if a mask that needs only two bytes
/// is stored in eight.
std::optional<std::uint64_t> load_mask(std::span<const std::byte> bytes, std::size_t at,
                                       bool narrow) noexcept {
  if (bytes.size() < at + (narrow ? narrow_mask_bytes : wide_mask_bytes)) return {};
  if (narrow) return load<std::uint16_t>(&bytes[at]);
  const auto mask = load<std::uint64_t>(&bytes[at]);
  return is_narrow(mask) ? std::nullopt : std::optional(mask);
}

/// Reads the header of a first or packed datagram, with the optional fields that follow it. `allowed` are
/// the flags that this kind may have.
std::optional<Datagram> read_described(DatagramKind kind, std::uint8_t allowed,
                                       std::span<const std::byte> bytes) noexcept {
  const auto sent_flags = load<std::uint8_t>(&bytes[at_flags]);
  const auto mask = load_mask(bytes, at_mask, (sent_flags & narrow_mask) != 0);
  const auto flags = static_cast<std::uint8_t>(sent_flags & ~narrow_mask);
  if (!mask || (flags & ~allowed) != 0) return {};
  Datagram d;
  d.kind = kind;
  d.first = {.label = load_label(bytes.data()),
             .flags = flags,
             .total = load<std::uint32_t>(&bytes[at_total]),
             .mask = *mask,
             .stamp_ns = static_cast<std::int64_t>(load<std::uint64_t>(&bytes[at_stamp]))};
  if (bytes.size() < d.first.bytes()) return {};
  if ((flags & rate_follows) != 0) {
    const std::size_t at = d.first.at_rate();
    d.first.rate = {load<std::uint32_t>(&bytes[at]), load<std::uint32_t>(&bytes[at + 4])};
  }
  if ((flags & history_follows) != 0) {
    const std::size_t at = d.first.at_history();
    d.first.history = {load<std::uint64_t>(&bytes[at]), load<std::uint64_t>(&bytes[at + 8])};
    if (d.first.history.reader == 0) return {};
  }
  if ((flags & channel_follows) != 0) {
    const std::size_t at = d.first.at_channel();
    d.first.channel = {load<std::uint32_t>(&bytes[at]), load<std::uint32_t>(&bytes[at + 4]),
                       load<std::uint64_t>(&bytes[at + 8])};
    if (d.first.channel.ordinal == 0 || d.first.channel.ordinal > ordinal_max) return {};
  }
  if ((flags & group_follows) != 0) {
    const std::size_t at = d.first.at_group();
    d.first.group = {load<std::uint32_t>(&bytes[at]), load<std::uint32_t>(&bytes[at + 4]),
                     load<std::uint64_t>(&bytes[at + 8])};
    if (d.first.group.ordinal == 0 || d.first.group.ordinal > ordinal_max) return {};
  }
  d.payload = bytes.subspan(d.first.bytes());
  return d;
}

std::optional<Datagram> read_first(std::span<const std::byte> bytes) noexcept {
  constexpr std::uint8_t not_in_groups = history_follows | channel_follows;
  constexpr std::uint8_t allowed =
      mask_words_follow | rate_follows | not_in_groups | group_follows | merged_masks;
  const std::optional<Datagram> d = read_described(DatagramKind::first, allowed, bytes);
  const bool of_group = d && (d->first.flags & group_follows) != 0;
  return of_group && (d->first.flags & not_in_groups) != 0 ? std::nullopt : d;
}

std::optional<Datagram> read_packed(std::span<const std::byte> bytes) noexcept {
  constexpr std::uint8_t allowed = mask_words_follow | channel_follows | lengths_follow;
  std::optional<Datagram> d = read_described(DatagramKind::packed, allowed, bytes);
  if (!d) return {};
  d->samples = load<std::uint16_t>(&bytes[at_samples]);
  d->bytes_each = load<std::uint16_t>(&bytes[at_bytes_each]);
  const bool lengths = (d->first.flags & lengths_follow) != 0;
  if (d->samples == 0 || d->samples > packed_samples_max || lengths != (d->bytes_each == 0)) return {};
  d->first.total = 0;
  return d;
}

/// Reads the short header of a whole datagram. Fields that this header does not contain become 0. The total
/// is computed from the length of the datagram.
std::optional<Datagram> read_whole(std::span<const std::byte> bytes) noexcept {
  const auto bits = load<std::uint32_t>(bytes.data());
  const auto mask = load_mask(bytes, at_mask, (bits >> narrow_bit & 1) != 0);
  if (!mask) return {};
  const auto flag = [bits](unsigned bit, std::uint8_t meant) { return (bits >> bit & 1) != 0 ? meant : 0; };
  Datagram d;
  d.kind = DatagramKind::whole;
  d.first = {.label = load_label(bytes.data()),
             .flags = static_cast<std::uint8_t>(channel_follows | flag(words_bit, mask_words_follow) |
                                                flag(merged_bit, merged_masks)),
             .mask = *mask,
             .stamp_ns = static_cast<std::int64_t>(load<std::uint64_t>(&bytes[at_stamp])),
             .channel = {.channel = bits >> short_channel_bit,
                         .ordinal = load<std::uint32_t>(&bytes[at_short_ordinal]),
                         .in_short = true}};
  d.first.label.variant = static_cast<std::uint16_t>(bits >> short_variant_bit) % whole_variants_end;
  d.payload = bytes.subspan(d.first.bytes_in_short());
  d.first.total = static_cast<std::uint32_t>(d.payload.size());
  return d.first.channel.ordinal == 0 ? std::nullopt : std::optional(d);
}

/// Reads a single datagram as the first and only datagram of a sample. The total is computed from the length
/// of the datagram.
std::optional<Datagram> read_single(std::span<const std::byte> bytes) noexcept {
  const auto flags = load<std::uint8_t>(&bytes[at_flags]);
  const auto mask = load_mask(bytes, at_single_mask, (flags & narrow_mask) != 0);
  if (!mask || (flags & ~(merged_masks | narrow_mask)) != 0) return {};
  Datagram d;
  d.kind = DatagramKind::first;
  d.first = {.label = load_label(bytes.data()),
             .flags = static_cast<std::uint8_t>(flags & merged_masks),
             .mask = *mask,
             .stamp_ns = static_cast<std::int64_t>(load<std::uint64_t>(&bytes[at_single_stamp]))};
  d.payload = bytes.subspan(d.first.bytes_in_single());
  d.first.total = static_cast<std::uint32_t>(d.payload.size());
  return d;
}

void store_mask_and_stamp(const FirstHeader& header, std::byte* out) noexcept {
  store(static_cast<std::uint64_t>(header.stamp_ns), out + at_stamp);
  store_mask(header.mask, out + at_mask);
}

}  // namespace

void encode(const FirstHeader& header, std::byte* out) noexcept {
  store_common(DatagramKind::first, header.flags | width_flag(header.mask), header.label, out);
  store(header.total, out + at_total);
  store_mask_and_stamp(header, out);
  if ((header.flags & rate_follows) != 0) {
    store(header.rate.min_period_us, out + header.at_rate());
    store(header.rate.ordinal, out + header.at_rate() + 4);
  }
  if ((header.flags & history_follows) != 0) {
    store(header.history.reader, out + header.at_history());
    store(header.history.oldest, out + header.at_history() + 8);
  }
  if ((header.flags & channel_follows) != 0) {
    store(header.channel.channel, out + header.at_channel());
    store(header.channel.sequence_high, out + header.at_channel() + 4);
    store(header.channel.ordinal, out + header.at_channel() + 8);
  }
  if ((header.flags & group_follows) != 0) {
    store(header.group.group, out + header.at_group());
    store(header.group.sequence_high, out + header.at_group() + 4);
    store(header.group.ordinal, out + header.at_group() + 8);
  }
}

bool fits_in_short(const FirstHeader& header) noexcept {
  const unsigned others = header.flags & ~unsigned{mask_words_follow | merged_masks};
  return others == channel_follows && header.channel.sequence_high == 0 &&
         header.channel.ordinal <= UINT32_MAX && header.channel.in_short &&
         header.label.variant < whole_variants_end;
}

void encode_in_short(const FirstHeader& header, std::byte* out) noexcept {
  const auto bit_of = [&](std::uint8_t flag, unsigned bit) {
    return (header.flags & flag) != 0 ? 1U << bit : 0U;
  };
  store_common(DatagramKind::whole, 0, header.label, out);
  store(load<std::uint8_t>(out) | bit_of(mask_words_follow, words_bit) | bit_of(merged_masks, merged_bit) |
            (is_narrow(header.mask) ? 1U << narrow_bit : 0U) |
            std::uint32_t{header.label.variant} << short_variant_bit |
            header.channel.channel % whole_channels_end << short_channel_bit,
        out);
  store(static_cast<std::uint32_t>(header.channel.ordinal), out + at_short_ordinal);
  store_mask_and_stamp(header, out);
}

void encode_in_single(const FirstHeader& header, std::byte* out) noexcept {
  store_common(DatagramKind::single, header.flags | width_flag(header.mask), header.label, out);
  store(static_cast<std::uint64_t>(header.stamp_ns), out + at_single_stamp);
  store_mask(header.mask, out + at_single_mask);
}

void encode(const FollowingHeader& header, std::byte* out) noexcept {
  if (!header.is_near()) {
    store_common(DatagramKind::far, 0, header.label, out);
    return store(header.offset, out + at_far_offset);
  }
  store_kind(DatagramKind::following, static_cast<std::uint8_t>(header.label.variant), out);
  store(header.label.writer, out + at_near_writer);
  store(header.label.sequence, out + at_near_sequence);
  store(static_cast<std::uint16_t>(header.offset), out + at_near_offset);
  store(static_cast<std::uint8_t>(header.offset >> 16), out + at_near_offset + 2);
}

void encode(const PackedHeader& header, std::byte* out) noexcept {
  encode(header.first, out);
  store_kind(DatagramKind::packed, header.first.flags | width_flag(header.first.mask), out);
  store(header.samples, out + at_samples);
  store(header.bytes_each, out + at_bytes_each);
}

FirstHeader header_behind(const FirstHeader& first, std::uint32_t samples, std::uint32_t total) noexcept {
  FirstHeader header = first;
  header.label.sequence += samples;
  header.total = total;
  if ((header.flags & channel_follows) == 0) return header;
  header.channel.sequence_high += header.label.sequence < samples ? 1 : 0;
  header.channel.ordinal += samples;
  return header;
}

namespace {

/// Writes fields at their offsets.
struct Store {
  std::byte* out;

  template <std::integral T>
  void operator()(std::size_t at, T value) const noexcept {
    store(static_cast<std::make_unsigned_t<T>>(value), out + at);
  }
};

/// Reads fields at their offsets.
struct Load {
  const std::byte* from;

  template <std::integral T>
  void operator()(std::size_t at, T& value) const noexcept {
    value = static_cast<T>(load<std::make_unsigned_t<T>>(from + at));
  }
};

template <class T, class Kind>
concept Is = std::same_as<std::remove_const_t<T>, Kind>;

// The fields of each kind without payload, at their offsets. `field` is a Store or a Load.

void each_field(Is<Heartbeat> auto& heartbeat, const auto& field) noexcept {
  field(2, heartbeat.port);
  field(4, heartbeat.writer);
  field(8, heartbeat.channel);
  field(12, heartbeat.waiting);
  field(16, heartbeat.first);
  field(24, heartbeat.end);
}

void each_field(Is<Ack> auto& ack, const auto& field) noexcept {
  field(4, ack.writer);
  field(8, ack.channel);
  field(16, ack.next);
}

void each_field(Is<Missing> auto& part, const auto& field) noexcept {
  field(0, part.ordinal);
  field(4, part.begin);
  field(8, part.end);
}

void each_field(Is<FlowMark> auto& mark, const auto& field) noexcept {
  field(2, mark.port);
  field(4, mark.flow);
  field(8, mark.position);
  field(20, mark.datagrams);
  field(32, mark.sent_at_ns);
}

void each_field(Is<FlowReport> auto& report, const auto& field) noexcept {
  field(4, report.flow);
  field(8, report.position);
  field(16, report.window_bytes);
  field(20, report.datagrams);
  field(24, report.came);
  field(28, report.longest);
  field(32, report.sent_at_ns);
}

void each_field(Is<GroupOffer> auto& offer, const auto& field) noexcept {
  field(2, offer.port);
  field(4, offer.writer);
  field(8, offer.group);
  field(12, offer.member);
  field(16, offer.address);
  field(20, offer.channel);
  field(24, offer.ahead);
}

void each_field(Is<GroupReport> auto& report, const auto& field) noexcept {
  field(4, report.writer);
  field(8, report.group);
  field(12, report.member);
  field(16, report.heard);
}

void each_field(Is<GroupProbe> auto& probe, const auto& field) noexcept {
  field(4, probe.writer);
  field(8, probe.group);
  field(16, probe.ordinal);
}

/// Writes `bytes` bytes. Bytes that belong to no field are 0.
template <class T>
void encode(DatagramKind kind, const T& from, std::size_t bytes, std::byte* out) noexcept {
  std::memset(out, 0, bytes);
  store_kind(kind, 0, out);
  each_field(from, Store{out});
}

/// Reads a datagram of `length` bytes. Returns nothing if the datagram has a different length, or any flag.
template <class T>
std::optional<T> read(std::span<const std::byte> bytes, std::size_t length) noexcept {
  if (bytes.size() != length || load<std::uint8_t>(&bytes[at_flags]) != 0) return {};
  std::optional<T> read(std::in_place);
  each_field(*read, Load{bytes.data()});
  return read;
}

std::optional<GroupOffer> read_group_offer(std::span<const std::byte> bytes) noexcept {
  const auto offer = read<GroupOffer>(bytes, group_offer_bytes);
  if (!offer) return {};
  const auto ahead = static_cast<std::int64_t>(ordinal_max);
  const bool is_private = offer->address == 0 || offer->address >> 16 == private_groups >> 16;
  const bool sound = offer->port != 0 && is_private && offer->ahead >= -ahead && offer->ahead <= ahead;
  return sound ? offer : std::nullopt;
}

std::optional<GroupReport> read_group_report(std::span<const std::byte> bytes) noexcept {
  const auto report = read<GroupReport>(bytes, group_report_bytes);
  return report && report->heard <= ordinal_max ? report : std::nullopt;
}

std::optional<GroupProbe> read_group_probe(std::span<const std::byte> bytes) noexcept {
  const auto probe = read<GroupProbe>(bytes, group_probe_bytes);
  return probe && probe->ordinal != 0 && probe->ordinal <= ordinal_max ? probe : std::nullopt;
}

std::optional<Heartbeat> read_heartbeat(std::span<const std::byte> bytes) noexcept {
  const auto heartbeat = read<Heartbeat>(bytes, heartbeat_bytes);
  const bool sound = heartbeat && heartbeat->port != 0 && heartbeat->first != 0 &&
                     heartbeat->first <= heartbeat->end && heartbeat->end <= ordinal_max;
  return sound ? heartbeat : std::nullopt;
}

std::optional<Ack> read_ack(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() < ack_header_bytes) return {};
  const std::size_t count = load<std::uint16_t>(&bytes[at_count]);
  if (count > missing_max) return {};
  auto ack = read<Ack>(bytes, ack_header_bytes + count * missing_bytes);
  if (!ack || ack->next == 0 || ack->next > ordinal_max) return {};
  ack->missing_count = count;
  for (std::size_t i = 0; i < count; ++i) {
    Missing& part = ack->missing[i];
    each_field(part, Load{&bytes[ack_header_bytes + i * missing_bytes]});
    if (part.begin > part.end) return {};
  }
  return ack;
}

std::optional<FlowMark> read_mark(std::span<const std::byte> bytes) noexcept {
  const auto mark = read<FlowMark>(bytes, mark_bytes);
  return mark && mark->port != 0 ? mark : std::nullopt;
}

}  // namespace

void encode(const Heartbeat& heartbeat, std::byte* out) noexcept {
  encode(DatagramKind::heartbeat, heartbeat, heartbeat_bytes, out);
}

void encode(const Ack& ack, std::byte* out) noexcept {
  encode(DatagramKind::ack, ack, ack_header_bytes, out);
  store(static_cast<std::uint16_t>(ack.missing_count), out + at_count);
  std::byte* place = out + ack_header_bytes;
  for (const Missing& part : ack.parts()) {
    each_field(part, Store{place});
    place += missing_bytes;
  }
}

void encode(const FlowMark& mark, std::byte* out) noexcept {
  encode(DatagramKind::mark, mark, mark_bytes, out);
}

void encode(const FlowReport& report, std::byte* out) noexcept {
  encode(DatagramKind::report, report, report_bytes, out);
}

void encode(const GroupOffer& offer, std::byte* out) noexcept {
  encode(DatagramKind::group_offer, offer, group_offer_bytes, out);
}

void encode(const GroupReport& report, std::byte* out) noexcept {
  encode(DatagramKind::group_report, report, group_report_bytes, out);
}

void encode(const GroupProbe& probe, std::byte* out) noexcept {
  encode(DatagramKind::group_probe, probe, group_probe_bytes, out);
}

/// Reads a following datagram. Refuses a datagram without payload.
static std::optional<Following> read_following(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() <= following_header_bytes) return {};
  const auto offset = load<std::uint16_t>(&bytes[at_near_offset]) |
                      std::uint32_t{load<std::uint8_t>(&bytes[at_near_offset + 2])} << 16;
  return Following{.label = {.writer = load<std::uint32_t>(&bytes[at_near_writer]),
                             .sequence = load<std::uint32_t>(&bytes[at_near_sequence]),
                             .variant = load<std::uint8_t>(&bytes[at_near_variant])},
                   .offset = offset,
                   .payload = bytes.subspan(following_header_bytes)};
}

/// Reads a far datagram. Refuses a datagram without payload, or one whose end exceeds the maximum total.
static std::optional<Following> read_far(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() <= far_header_bytes || load<std::uint8_t>(&bytes[at_flags]) != 0) return {};
  const Following far{.label = load_label(bytes.data()),
                      .offset = load<std::uint32_t>(&bytes[at_far_offset]),
                      .payload = bytes.subspan(far_header_bytes)};
  if (far.payload.size() > UINT32_MAX - far.offset) return {};
  return far;
}

AnyDatagram decode(std::span<const std::byte> bytes) noexcept {
  const std::optional<DatagramKind> kind = kind_of_bytes(bytes);
  const auto as = [&]<class T>(std::in_place_type_t<T> type, const auto& sound) {
    return sound ? AnyDatagram(type, *sound) : AnyDatagram(Malformed{kind});
  };
  constexpr std::in_place_type_t<Datagram> sample;
  constexpr std::in_place_type_t<Answer> answer;
  if (!kind) return Malformed{};
  switch (*kind) {
    case DatagramKind::following:
      return as(std::in_place_type<Following>, read_following(bytes));
    case DatagramKind::far:
      return as(std::in_place_type<Following>, read_far(bytes));
    case DatagramKind::first:
      return as(sample, read_first(bytes));
    case DatagramKind::packed:
      return as(sample, read_packed(bytes));
    case DatagramKind::whole:
      return as(sample, read_whole(bytes));
    case DatagramKind::single:
      return as(sample, read_single(bytes));
    case DatagramKind::heartbeat:
      return as(std::in_place_type<Heartbeat>, read_heartbeat(bytes));
    case DatagramKind::mark:
      return as(std::in_place_type<FlowMark>, read_mark(bytes));
    case DatagramKind::group_offer:
      return as(std::in_place_type<GroupOffer>, read_group_offer(bytes));
    case DatagramKind::group_probe:
      return as(std::in_place_type<GroupProbe>, read_group_probe(bytes));
    case DatagramKind::ack:
      return as(answer, read_ack(bytes));
    case DatagramKind::report:
      return as(answer, read<FlowReport>(bytes, report_bytes));
    case DatagramKind::group_report:
      return as(answer, read_group_report(bytes));
  }
  return Malformed{};
}

bool PackedBodies::sound() const noexcept {
  if (bytes_each_ != 0) return rest_.size() == samples_ * bytes_each_;
  std::size_t at = 0;
  for (std::size_t i = 0; i < samples_; ++i) {
    if (rest_.size() - at < length_bytes) return false;
    const std::size_t bytes = load<std::uint16_t>(&rest_[at]);
    at += length_bytes;
    if (rest_.size() - at < bytes) return false;
    at += bytes;
  }
  return true;  // any further bytes are padding
}

std::span<const std::byte> PackedBodies::next() noexcept {
  std::size_t bytes = bytes_each_;
  if (bytes == 0) {
    bytes = load<std::uint16_t>(rest_.data());
    rest_ = rest_.subspan(length_bytes);
  }
  const auto body = rest_.first(bytes);
  rest_ = rest_.subspan(bytes);
  return body;
}

void store_word(std::uint64_t word, std::byte* out) noexcept { store(word, out); }
void store_length(std::size_t bytes, std::byte* out) noexcept {
  store(static_cast<std::uint16_t>(bytes), out);
}
std::uint64_t load_word(const std::byte* from) noexcept { return load<std::uint64_t>(from); }

std::uint64_t widen_sequence(std::uint64_t reference, std::uint32_t low) noexcept {
  const auto distance = static_cast<std::int32_t>(low - static_cast<std::uint32_t>(reference));
  if (distance < 0 && reference < static_cast<std::uint64_t>(-static_cast<std::int64_t>(distance)))
    return low;
  return reference + static_cast<std::uint64_t>(static_cast<std::int64_t>(distance));
}

}  // namespace sft::udp
