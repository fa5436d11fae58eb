#include "udp_transport/wire/datagram.h"

#include <concepts>

namespace sft::udp {

namespace {

// The offsets of the fields that all kinds of samples share, and of the fields behind them.
constexpr std::size_t at_kind = 0, at_flags = 1, at_variant = 2, at_writer = 4, at_sequence = 8;
constexpr std::size_t at_total = 12, at_mask = 16, at_stamp = 24;
constexpr std::size_t at_offset = 12;
constexpr std::size_t at_samples = 12, at_bytes_each = 14;
constexpr std::size_t at_short_ordinal = 12;
// The bits in the first 32 bits of a whole datagram.
constexpr unsigned words_bit = 8, merged_bit = 9, short_variant_bit = 10, short_channel_bit = 21;
static_assert(whole_numbers_end == 1U << (short_channel_bit - short_variant_bit) &&
              whole_numbers_end == 1U << (32 - short_channel_bit));
constexpr std::size_t at_period = first_header_bytes, at_ordinal = at_period + 4;
// The offsets in heartbeats and acks. These name the writer where samples do.
constexpr std::size_t at_port = 2, at_channel_number = 8, at_waiting = 12, at_first = 16, at_end = 24;
constexpr std::size_t at_count = 2, at_reserved = 12, at_next = 16;
// The offsets in marks and reports.
constexpr std::size_t at_flow = 4, at_position = 8, at_window = 16, at_datagrams = 20, at_came = 24;
constexpr std::size_t at_padding = 28, at_sent = 32;

// The offsets in group offers and reports.
constexpr std::size_t at_group_number = 8, at_member = 12;
constexpr std::size_t at_group_address = 16, at_offered_channel = 20, at_ahead = 24, at_heard = 16;
// The offsets in group probes. Their first fields are where those of offers are.
constexpr std::size_t at_probe_padding = 12, at_probed = 16;

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

/// Does what kind_of() does, but the compiler may put its code into its callers.
std::optional<DatagramKind> claimed_kind(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() < following_header_bytes || bytes.size() > datagram_bytes_max) return {};
  const auto version_and_kind = load<std::uint8_t>(&bytes[at_kind]);
  if (version_and_kind >> 4 != wire_version) return {};
  const auto kind = static_cast<DatagramKind>(version_and_kind & 0xf);
  if (kind < DatagramKind::first || kind > DatagramKind::group_probe) return {};
  return kind;
}

SampleLabel load_label(const std::byte* from) noexcept {
  return {.writer = load<std::uint32_t>(from + at_writer),
          .sequence = load<std::uint32_t>(from + at_sequence),
          .variant = load<std::uint16_t>(from + at_variant)};
}

/// Reads the header of a first or packed datagram, with the marks behind it that this kind may have.
std::optional<Datagram> read_described(DatagramKind kind, std::uint8_t allowed,
                                       std::span<const std::byte> bytes) noexcept {
  if (bytes.size() < first_header_bytes) return {};
  const auto flags = load<std::uint8_t>(&bytes[at_flags]);
  if ((flags & ~allowed) != 0) return {};
  Datagram d;
  d.kind = kind;
  d.first = {.label = load_label(bytes.data()),
             .flags = flags,
             .total = load<std::uint32_t>(&bytes[at_total]),
             .mask = load<std::uint64_t>(&bytes[at_mask]),
             .stamp_ns = static_cast<std::int64_t>(load<std::uint64_t>(&bytes[at_stamp]))};
  if (bytes.size() < d.first.bytes()) return {};
  if ((flags & rate_follows) != 0) {
    d.first.rate = {load<std::uint32_t>(&bytes[at_period]), load<std::uint32_t>(&bytes[at_ordinal])};
    if (d.first.rate.min_period_us == 0) return {};
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
  constexpr std::uint8_t not_in_groups = rate_follows | history_follows | channel_follows;
  constexpr std::uint8_t allowed = mask_words_follow | not_in_groups | group_follows | merged_masks;
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

/// Reads the short header of a whole datagram. Fields that this header leaves out are 0, and the length of
/// the datagram tells the total.
std::optional<Datagram> read_whole(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() < first_header_bytes) return {};
  const auto bits = load<std::uint32_t>(bytes.data());
  const auto flag = [bits](unsigned bit, std::uint8_t meant) { return (bits >> bit & 1) != 0 ? meant : 0; };
  Datagram d;
  d.kind = DatagramKind::whole;
  d.first = {.label = load_label(bytes.data()),
             .flags = static_cast<std::uint8_t>(channel_follows | flag(words_bit, mask_words_follow) |
                                                flag(merged_bit, merged_masks)),
             .total = static_cast<std::uint32_t>(bytes.size() - first_header_bytes),
             .mask = load<std::uint64_t>(&bytes[at_mask]),
             .stamp_ns = static_cast<std::int64_t>(load<std::uint64_t>(&bytes[at_stamp])),
             .channel = {.channel = bits >> short_channel_bit,
                         .ordinal = load<std::uint32_t>(&bytes[at_short_ordinal]),
                         .in_short = true}};
  d.first.label.variant = static_cast<std::uint16_t>(bits >> short_variant_bit) % whole_numbers_end;
  d.payload = bytes.subspan(first_header_bytes);
  return d.first.channel.ordinal == 0 ? std::nullopt : std::optional(d);
}

void store_mask_and_stamp(const FirstHeader& header, std::byte* out) noexcept {
  store(header.mask, out + at_mask);
  store(static_cast<std::uint64_t>(header.stamp_ns), out + at_stamp);
}

}  // namespace

void encode(const FirstHeader& header, std::byte* out) noexcept {
  store_common(DatagramKind::first, header.flags, header.label, out);
  store(header.total, out + at_total);
  store_mask_and_stamp(header, out);
  if ((header.flags & rate_follows) != 0) {
    store(header.rate.min_period_us, out + at_period);
    store(header.rate.ordinal, out + at_ordinal);
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
         header.label.variant < whole_numbers_end;
}

void encode_in_short(const FirstHeader& header, std::byte* out) noexcept {
  const auto bit_of = [&](std::uint8_t flag, unsigned bit) {
    return (header.flags & flag) != 0 ? 1U << bit : 0U;
  };
  store_common(DatagramKind::whole, 0, header.label, out);
  store(load<std::uint8_t>(out) | bit_of(mask_words_follow, words_bit) | bit_of(merged_masks, merged_bit) |
            std::uint32_t{header.label.variant} << short_variant_bit |
            header.channel.channel % whole_numbers_end << short_channel_bit,
        out);
  store(static_cast<std::uint32_t>(header.channel.ordinal), out + at_short_ordinal);
  store_mask_and_stamp(header, out);
}

void encode(const FollowingHeader& header, std::byte* out) noexcept {
  store_common(DatagramKind::following, 0, header.label, out);
  store(header.offset, out + at_offset);
}

void encode(const PackedHeader& header, std::byte* out) noexcept {
  encode(header.first, out);
  store_kind(DatagramKind::packed, header.first.flags, out);
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

void encode(const Heartbeat& heartbeat, std::byte* out) noexcept {
  store_kind(DatagramKind::heartbeat, 0, out);
  store(heartbeat.port, out + at_port);
  store(heartbeat.writer, out + at_writer);
  store(heartbeat.channel, out + at_channel_number);
  store(heartbeat.waiting, out + at_waiting);
  store(heartbeat.first, out + at_first);
  store(heartbeat.end, out + at_end);
}

void encode(const Ack& ack, std::byte* out) noexcept {
  store_kind(DatagramKind::ack, 0, out);
  store(static_cast<std::uint16_t>(ack.missing_count), out + at_count);
  store(ack.writer, out + at_writer);
  store(ack.channel, out + at_channel_number);
  store(std::uint32_t{0}, out + at_reserved);
  store(ack.next, out + at_next);
  std::byte* place = out + ack_header_bytes;
  for (const Missing& part : ack.parts()) {
    store(part.ordinal, place);
    store(part.begin, place + 4);
    store(part.end, place + 8);
    place += missing_bytes;
  }
}

void encode(const FlowMark& mark, std::byte* out) noexcept {
  store_kind(DatagramKind::mark, 0, out);
  store(mark.port, out + at_port);
  store(mark.flow, out + at_flow);
  store(mark.position, out + at_position);
  store(std::uint32_t{0}, out + at_window);
  store(mark.datagrams, out + at_datagrams);
  store(std::uint64_t{0}, out + at_came);
  store(static_cast<std::uint64_t>(mark.sent_at_ns), out + at_sent);
}

void encode(const FlowReport& report, std::byte* out) noexcept {
  store_kind(DatagramKind::report, 0, out);
  store(std::uint16_t{0}, out + at_port);
  store(report.flow, out + at_flow);
  store(report.position, out + at_position);
  store(report.window_bytes, out + at_window);
  store(report.datagrams, out + at_datagrams);
  store(report.came, out + at_came);
  store(std::uint32_t{0}, out + at_padding);
  store(static_cast<std::uint64_t>(report.sent_at_ns), out + at_sent);
}

std::optional<DatagramKind> kind_of(std::span<const std::byte> bytes) noexcept { return claimed_kind(bytes); }

void encode(const GroupOffer& offer, std::byte* out) noexcept {
  store_kind(DatagramKind::group_offer, 0, out);
  store(offer.port, out + at_port);
  store(offer.writer, out + at_writer);
  store(offer.group, out + at_group_number);
  store(offer.member, out + at_member);
  store(offer.address, out + at_group_address);
  store(offer.channel, out + at_offered_channel);
  store(static_cast<std::uint64_t>(offer.ahead), out + at_ahead);
}

void encode(const GroupReport& report, std::byte* out) noexcept {
  store_kind(DatagramKind::group_report, 0, out);
  store(std::uint16_t{0}, out + at_port);
  store(report.writer, out + at_writer);
  store(report.group, out + at_group_number);
  store(report.member, out + at_member);
  store(report.heard, out + at_heard);
}

void encode(const GroupProbe& probe, std::byte* out) noexcept {
  store_kind(DatagramKind::group_probe, 0, out);
  store(std::uint16_t{0}, out + at_port);
  store(probe.writer, out + at_writer);
  store(probe.group, out + at_group_number);
  store(std::uint32_t{0}, out + at_probe_padding);
  store(probe.ordinal, out + at_probed);
}

static std::optional<GroupOffer> read_group_offer(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != group_offer_bytes) return {};
  if (load<std::uint8_t>(&bytes[at_flags]) != 0) return {};
  const GroupOffer offer{.writer = load<std::uint32_t>(&bytes[at_writer]),
                         .group = load<std::uint32_t>(&bytes[at_group_number]),
                         .member = load<std::uint32_t>(&bytes[at_member]),
                         .port = load<std::uint16_t>(&bytes[at_port]),
                         .address = load<std::uint32_t>(&bytes[at_group_address]),
                         .channel = load<std::uint32_t>(&bytes[at_offered_channel]),
                         .ahead = static_cast<std::int64_t>(load<std::uint64_t>(&bytes[at_ahead]))};
  const auto ahead = static_cast<std::int64_t>(ordinal_max);
  const bool is_private = offer.address == 0 || offer.address >> 16 == private_groups >> 16;
  const bool sound = offer.port != 0 && is_private && offer.ahead >= -ahead && offer.ahead <= ahead;
  return sound ? std::optional(offer) : std::nullopt;
}

static std::optional<GroupReport> read_group_report(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != group_report_bytes) return {};
  if (load<std::uint8_t>(&bytes[at_flags]) != 0) return {};
  const GroupReport report{.writer = load<std::uint32_t>(&bytes[at_writer]),
                           .group = load<std::uint32_t>(&bytes[at_group_number]),
                           .member = load<std::uint32_t>(&bytes[at_member]),
                           .heard = load<std::uint64_t>(&bytes[at_heard])};
  return report.heard <= ordinal_max ? std::optional(report) : std::nullopt;
}

static std::optional<GroupProbe> read_group_probe(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != group_probe_bytes) return {};
  if (load<std::uint8_t>(&bytes[at_flags]) != 0) return {};
  const GroupProbe probe{.writer = load<std::uint32_t>(&bytes[at_writer]),
                         .group = load<std::uint32_t>(&bytes[at_group_number]),
                         .ordinal = load<std::uint64_t>(&bytes[at_probed])};
  return probe.ordinal != 0 && probe.ordinal <= ordinal_max ? std::optional(probe) : std::nullopt;
}

static std::optional<Heartbeat> read_heartbeat(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != heartbeat_bytes) return {};
  if (load<std::uint8_t>(&bytes[at_flags]) != 0) return {};
  const Heartbeat heartbeat{.writer = load<std::uint32_t>(&bytes[at_writer]),
                            .channel = load<std::uint32_t>(&bytes[at_channel_number]),
                            .port = load<std::uint16_t>(&bytes[at_port]),
                            .first = load<std::uint64_t>(&bytes[at_first]),
                            .end = load<std::uint64_t>(&bytes[at_end]),
                            .waiting = load<std::uint32_t>(&bytes[at_waiting])};
  const bool sound = heartbeat.port != 0 && heartbeat.first != 0 && heartbeat.first <= heartbeat.end &&
                     heartbeat.end <= ordinal_max;
  return sound ? std::optional(heartbeat) : std::nullopt;
}

static std::optional<Ack> read_ack(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() < ack_header_bytes) return {};
  const std::size_t count = load<std::uint16_t>(&bytes[at_count]);
  if (load<std::uint8_t>(&bytes[at_flags]) != 0 || count > missing_max) return {};
  if (bytes.size() != ack_header_bytes + count * missing_bytes) return {};
  Ack ack{.writer = load<std::uint32_t>(&bytes[at_writer]),
          .channel = load<std::uint32_t>(&bytes[at_channel_number]),
          .next = load<std::uint64_t>(&bytes[at_next]),
          .missing_count = count};
  if (ack.next == 0 || ack.next > ordinal_max) return {};
  for (std::size_t i = 0; i < count; ++i) {
    const std::byte* place = &bytes[ack_header_bytes + i * missing_bytes];
    ack.missing[i] = {load<std::uint32_t>(place), load<std::uint32_t>(place + 4),
                      load<std::uint32_t>(place + 8)};
    if (ack.missing[i].begin > ack.missing[i].end) return {};
  }
  return ack;
}

static std::optional<FlowMark> read_mark(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != mark_bytes) return {};
  const FlowMark mark{.flow = load<std::uint32_t>(&bytes[at_flow]),
                      .port = load<std::uint16_t>(&bytes[at_port]),
                      .position = load<std::uint64_t>(&bytes[at_position]),
                      .datagrams = load<std::uint32_t>(&bytes[at_datagrams]),
                      .sent_at_ns = static_cast<std::int64_t>(load<std::uint64_t>(&bytes[at_sent]))};
  const bool sound = load<std::uint8_t>(&bytes[at_flags]) == 0 && mark.port != 0;
  return sound ? std::optional(mark) : std::nullopt;
}

static std::optional<FlowReport> read_report(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() != report_bytes) return {};
  if (load<std::uint8_t>(&bytes[at_flags]) != 0) return {};
  return FlowReport{.flow = load<std::uint32_t>(&bytes[at_flow]),
                    .position = load<std::uint64_t>(&bytes[at_position]),
                    .window_bytes = load<std::uint32_t>(&bytes[at_window]),
                    .datagrams = load<std::uint32_t>(&bytes[at_datagrams]),
                    .came = load<std::uint32_t>(&bytes[at_came]),
                    .sent_at_ns = static_cast<std::int64_t>(load<std::uint64_t>(&bytes[at_sent]))};
}

/// A datagram without payload says nothing and is refused, like one that ends beyond what a total can be.
static std::optional<Following> read_following(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() <= following_header_bytes || load<std::uint8_t>(&bytes[at_flags]) != 0) return {};
  const Following following{.label = load_label(bytes.data()),
                            .offset = load<std::uint32_t>(&bytes[at_offset]),
                            .payload = bytes.subspan(following_header_bytes)};
  if (following.payload.size() > UINT32_MAX - following.offset) return {};
  return following;
}

/// Reads the bytes if they are of that kind.
template <class Read>
static auto read_if(DatagramKind kind, std::span<const std::byte> bytes, const Read& read) noexcept {
  return claimed_kind(bytes) == kind ? read(bytes) : decltype(read(bytes)){};
}

std::optional<Heartbeat> parse_heartbeat(std::span<const std::byte> bytes) noexcept {
  return read_if(DatagramKind::heartbeat, bytes, read_heartbeat);
}
std::optional<Ack> parse_ack(std::span<const std::byte> bytes) noexcept {
  return read_if(DatagramKind::ack, bytes, read_ack);
}
std::optional<GroupOffer> parse_group_offer(std::span<const std::byte> bytes) noexcept {
  return read_if(DatagramKind::group_offer, bytes, read_group_offer);
}
std::optional<GroupReport> parse_group_report(std::span<const std::byte> bytes) noexcept {
  return read_if(DatagramKind::group_report, bytes, read_group_report);
}
std::optional<GroupProbe> parse_group_probe(std::span<const std::byte> bytes) noexcept {
  return read_if(DatagramKind::group_probe, bytes, read_group_probe);
}
std::optional<FlowMark> parse_mark(std::span<const std::byte> bytes) noexcept {
  return read_if(DatagramKind::mark, bytes, read_mark);
}
std::optional<FlowReport> parse_report(std::span<const std::byte> bytes) noexcept {
  return read_if(DatagramKind::report, bytes, read_report);
}

std::optional<Datagram> parse(std::span<const std::byte> bytes) noexcept {
  AnyDatagram any = decode(bytes);
  if (const Datagram* d = std::get_if<Datagram>(&any)) return *d;
  const Following* following = std::get_if<Following>(&any);
  if (following == nullptr) return {};
  Datagram d;
  d.kind = DatagramKind::following;
  d.first.label = following->label;
  d.offset = following->offset;
  d.payload = following->payload;
  return d;
}

AnyDatagram decode(std::span<const std::byte> bytes) noexcept {
  const std::optional<DatagramKind> kind = claimed_kind(bytes);
  const auto as = [&]<class T>(std::in_place_type_t<T> type, const auto& sound) {
    return sound ? AnyDatagram(type, *sound) : AnyDatagram(Malformed{kind});
  };
  constexpr std::in_place_type_t<Datagram> sample;
  constexpr std::in_place_type_t<Answer> answer;
  if (!kind) return Malformed{};
  switch (*kind) {
    case DatagramKind::following:
      return as(std::in_place_type<Following>, read_following(bytes));
    case DatagramKind::first:
      return as(sample, read_first(bytes));
    case DatagramKind::packed:
      return as(sample, read_packed(bytes));
    case DatagramKind::whole:
      return as(sample, read_whole(bytes));
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
      return as(answer, read_report(bytes));
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
  return true;  // what follows is padding
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
