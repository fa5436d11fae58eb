// The headers of SFT datagrams (wire_format.md): from structs to bytes and back. Pure and bounds-checked.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace sft::udp {

inline constexpr std::uint8_t wire_version = 1;
inline constexpr std::size_t first_header_bytes = 32;
inline constexpr std::size_t following_header_bytes = 16;
inline constexpr std::size_t datagram_bytes_max = 65507;  ///< of a UDP payload over IPv4
inline constexpr std::size_t datagram_bytes_min = 548;    ///< what every IPv4 path takes

enum class DatagramKind : std::uint8_t {
  first = 1,         ///< begins a sample
  following = 2,     ///< a later part of its body
  heartbeat = 3,     ///< of a channel: what its writer has sent, and still has
  ack = 4,           ///< of a channel, the other way: what has come, and what is missing
  packed = 5,        ///< whole small samples, whose sequences and ordinals follow one another
  group_offer = 6,   ///< to a process: in which multicast group it is sent the same
  group_report = 7,  ///< the other way: what has come there
  mark = 8,          ///< between samples: how much was sent to a socket up to here
  report = 9,        ///< the other way: the mark has come, and how much may be under way
  whole = 10,        ///< a sample in a channel that needs no other, in short
};

/// Flags of a first datagram. Its mask field is a hash, and the mask's words stand right before the payload.
inline constexpr std::uint8_t mask_words_follow = 1;
/// The sample passed a gate for a maximum rate: `rate` stands right behind the header.
inline constexpr std::uint8_t rate_follows = 2;
inline constexpr std::size_t rate_bytes = 8;
/// The sample is for one late reader only: `history` stands behind that.
inline constexpr std::uint8_t history_follows = 4;
inline constexpr std::size_t history_bytes = 16;
/// The sample travels in a channel, reliably: `channel` stands behind that.
inline constexpr std::uint8_t channel_follows = 8;
inline constexpr std::size_t channel_bytes = 16;
/// A whole datagram has room for variants below this, for a channel's number modulo this, and for 32 bits of
/// sequence and ordinal.
inline constexpr std::uint32_t whole_numbers_end = 2048;
/// The sample is sent to a multicast group: `group` stands behind that.
inline constexpr std::uint8_t group_follows = 64;
inline constexpr std::size_t group_bytes = 16;
/// The mask is the union of those of several readers: it is for each whose mask it contains.
inline constexpr std::uint8_t merged_masks = 128;
/// Groups are of the range that RFC 2365 leaves to everybody, 239.255.0.0/16, and datagrams to them go to one
/// port, that DDS takes in no domain.
inline constexpr std::uint32_t private_groups = 0xEFFF0000;
inline constexpr std::uint16_t group_port = 22155;
inline constexpr std::size_t group_offer_bytes = 32;
inline constexpr std::size_t group_report_bytes = 24;
/// Of a packed datagram: before each sample stands how long it is; else all are equally long.
inline constexpr std::uint8_t lengths_follow = 16;
inline constexpr std::size_t length_bytes = 2;
inline constexpr std::size_t packed_samples_max = 256;
inline constexpr std::size_t heartbeat_bytes = 32;
inline constexpr std::size_t ack_header_bytes = 24;
inline constexpr std::size_t missing_bytes = 12;
inline constexpr std::size_t mark_bytes = 40;
inline constexpr std::size_t report_bytes = 40;  ///< no more than what it answers
/// As many as fit into a datagram that every path takes.
inline constexpr std::size_t missing_max = (datagram_bytes_min - ack_header_bytes) / missing_bytes;

/// So that nothing overflows that is added to it.
inline constexpr std::uint64_t ordinal_max = std::uint64_t{1} << 62;

/// Names one encoding of one sample. Equal in all its datagrams, and different in all others for a long time.
struct SampleLabel {
  std::uint32_t writer = 0;    ///< low half of the writer's id
  std::uint32_t sequence = 0;  ///< low half of the sequence
  std::uint16_t variant = 0;   ///< the writer's number for the mask
  friend bool operator==(const SampleLabel&, const SampleLabel&) = default;
};

/// The gate that a sample passed at its writer (core/seam/rate_gate.h), as the how-manieth.
struct RateMark {
  std::uint32_t min_period_us = 0;
  std::uint32_t ordinal = 0;
  friend bool operator==(const RateMark&, const RateMark&) = default;
};

/// A sample of those that begin with what was retained.
struct HistoryMark {
  std::uint64_t reader = 0;  ///< its id
  std::uint64_t oldest = 0;  ///< sequence of the first sample that it is sent
  friend bool operator==(const HistoryMark&, const HistoryMark&) = default;
};

/// The place of a sample in a channel.
struct ChannelMark {
  std::uint32_t channel = 0;        ///< the writer's number for it
  std::uint32_t sequence_high = 0;  ///< high half of the sample's sequence
  std::uint64_t ordinal = 0;        ///< counts the samples in the channel, from 1
  /// The other end knows the channel: the low bits of its number will do, or are all that came of it.
  bool in_short = false;
  friend bool operator==(const ChannelMark&, const ChannelMark&) = default;
};

/// The place of a sample among those that were sent to a group.
struct GroupMark {
  std::uint32_t group = 0;          ///< the writer's number for it
  std::uint32_t sequence_high = 0;  ///< high half of the sample's sequence
  std::uint64_t ordinal = 0;        ///< counts the samples sent to it, from 1
  friend bool operator==(const GroupMark&, const GroupMark&) = default;
};

struct FirstHeader {
  SampleLabel label;
  std::uint8_t flags = 0;
  std::uint32_t total = 0;    ///< bytes of the body, without encapsulation
  std::uint64_t mask = 0;     ///< leaf bits, or FieldMask::hash() where there are more than 64 leaves
  std::int64_t stamp_ns = 0;  ///< CLOCK_REALTIME at publish
  RateMark rate{};            ///< where the flag says so
  HistoryMark history{};      ///< likewise
  ChannelMark channel{};      ///< likewise
  GroupMark group{};          ///< likewise

  /// With what the flags say follows it, but for the mask's words.
  std::size_t bytes() const { return at_group() + ((flags & group_follows) != 0 ? group_bytes : 0); }
  std::size_t at_group() const { return at_channel() + ((flags & channel_follows) != 0 ? channel_bytes : 0); }
  std::size_t at_history() const {
    return first_header_bytes + ((flags & rate_follows) != 0 ? rate_bytes : 0);
  }
  std::size_t at_channel() const {
    return at_history() + ((flags & history_follows) != 0 ? history_bytes : 0);
  }
};

struct FollowingHeader {
  SampleLabel label;
  std::uint32_t offset = 0;  ///< of the payload in the body
};

/// What the samples of a packed datagram have in common.
struct PackedHeader {
  FirstHeader first;             ///< of the first of them; its total counts for nothing
  std::uint16_t samples = 0;     ///< 1 to packed_samples_max
  std::uint16_t bytes_each = 0;  ///< 0 where the flag says that lengths follow, and only there
};

void encode(const FirstHeader& header, std::byte* out) noexcept;      ///< header.bytes()
void encode(const FollowingHeader& header, std::byte* out) noexcept;  ///< following_header_bytes
void encode(const PackedHeader& header, std::byte* out) noexcept;     ///< header.first.bytes()

/// A whole datagram can say all that this does, if it also has the body as a whole.
bool fits_in_short(const FirstHeader& header) noexcept;
void encode_in_short(const FirstHeader& header, std::byte* out) noexcept;  ///< first_header_bytes

/// Of the sample so many behind the first one, where their sequences and ordinals follow one another.
FirstHeader header_behind(const FirstHeader& first, std::uint32_t samples, std::uint32_t total) noexcept;

/// Of the samples in a channel, [first, end) were sent and can be sent again; those before cannot.
struct Heartbeat {
  std::uint32_t writer = 0;
  std::uint32_t channel = 0;
  std::uint16_t port = 0;  ///< where acks go, at the address that it comes from
  std::uint64_t first = 0;
  std::uint64_t end = 0;
  std::uint32_t waiting = 0;  ///< behind `end`: were published, and will be sent
  friend bool operator==(const Heartbeat&, const Heartbeat&) = default;
};

/// A part of a sample that has not come: bytes [begin, end) of its body, or, if these are equal, nothing is
/// known of it yet and its first datagram is asked for.
struct Missing {
  std::uint32_t ordinal = 0;  ///< low half
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  friend bool operator==(const Missing&, const Missing&) = default;
};

struct Ack {
  std::uint32_t writer = 0;
  std::uint32_t channel = 0;
  std::uint64_t next = 0;  ///< ordinal: nothing before it is wanted any more
  std::array<Missing, missing_max> missing{};
  std::size_t missing_count = 0;

  std::span<const Missing> parts() const { return {missing.data(), missing_count}; }
  std::size_t bytes() const { return ack_header_bytes + missing_count * missing_bytes; }
};

/// Stands behind what was sent to a socket, whatever it was.
struct FlowMark {
  std::uint32_t flow = 0;       ///< the sender's number for that socket
  std::uint16_t port = 0;       ///< where the report goes, at the address that the mark comes from
  std::uint64_t position = 0;   ///< counts what was sent before it
  std::uint32_t datagrams = 0;  ///< of these, from where the mark comes from
  std::int64_t sent_at_ns = 0;  ///< by the sender's clock
  friend bool operator==(const FlowMark&, const FlowMark&) = default;
};

/// What the receiver says to a mark, most of which it repeats.
struct FlowReport {
  std::uint32_t flow = 0;
  std::uint64_t position = 0;
  std::uint32_t window_bytes = 0;  ///< that may be under way, as the receiving kernel counts
  std::uint32_t datagrams = 0;
  std::uint32_t came = 0;  ///< of these; all that were sent before the receiver knew the sender count as come
  std::int64_t sent_at_ns = 0;
  friend bool operator==(const FlowReport&, const FlowReport&) = default;
};

/// To one member of a group. Its samples are those of a channel, too: their ordinals there are `ahead` of
/// those in the group.
struct GroupOffer {
  std::uint32_t writer = 0;
  std::uint32_t group = 0;    ///< the writer's number for it
  std::uint32_t member = 0;   ///< to be named in reports
  std::uint16_t port = 0;     ///< where reports go, at the address that it comes from
  std::uint32_t address = 0;  ///< of the group, IPv4; 0: the member is in it no more
  std::uint32_t channel = 0;  ///< 0: in none, it is sent by best effort
  std::int64_t ahead = 0;
  friend bool operator==(const GroupOffer&, const GroupOffer&) = default;
};

struct GroupReport {
  std::uint32_t writer = 0;
  std::uint32_t group = 0;
  std::uint32_t member = 0;
  std::uint64_t heard = 0;  ///< ordinal: the last that has come; 0: the offer is to be repeated
  friend bool operator==(const GroupReport&, const GroupReport&) = default;
};

void encode(const GroupOffer& offer, std::byte* out) noexcept;    ///< group_offer_bytes
void encode(const GroupReport& report, std::byte* out) noexcept;  ///< group_report_bytes
std::optional<GroupOffer> parse_group_offer(std::span<const std::byte> bytes) noexcept;
std::optional<GroupReport> parse_group_report(std::span<const std::byte> bytes) noexcept;
void encode(const Heartbeat& heartbeat, std::byte* out) noexcept;  ///< heartbeat_bytes
void encode(const Ack& ack, std::byte* out) noexcept;              ///< ack.bytes()
void encode(const FlowMark& mark, std::byte* out) noexcept;        ///< mark_bytes
void encode(const FlowReport& report, std::byte* out) noexcept;    ///< report_bytes
std::optional<Heartbeat> parse_heartbeat(std::span<const std::byte> bytes) noexcept;
std::optional<Ack> parse_ack(std::span<const std::byte> bytes) noexcept;
std::optional<FlowMark> parse_mark(std::span<const std::byte> bytes) noexcept;
std::optional<FlowReport> parse_report(std::span<const std::byte> bytes) noexcept;
/// Of a datagram of this version. It may be none of these, or not sound.
std::optional<DatagramKind> kind_of(std::span<const std::byte> bytes) noexcept;

/// True for datagrams that go back to the sender of samples: acks and reports.
constexpr bool is_answer(std::optional<DatagramKind> kind) {
  return kind == DatagramKind::ack || kind == DatagramKind::report || kind == DatagramKind::group_report;
}

/// A received datagram of a sample whose header is sound. What it says of the sample is only claimed.
struct Datagram {
  DatagramKind kind{};
  /// Of a following datagram only the label is set; a whole one reads as if a first one had said the same,
  /// but that the mask's words count in its total.
  FirstHeader first;
  std::uint32_t offset = 0;            ///< of the payload in the body; 0 in a first datagram
  std::uint16_t samples = 0;           ///< of a packed datagram, as in its header
  std::uint16_t bytes_each = 0;        ///< likewise
  std::span<const std::byte> payload;  ///< begins with the mask's words where the flag says so

  const SampleLabel& label() const { return first.label; }
};

/// The most frequent kind by far, without what it does not have.
struct Following {
  SampleLabel label;
  std::uint32_t offset = 0;
  std::span<const std::byte> payload;
};
/// Of bytes of that kind.
std::optional<Following> parse_following(std::span<const std::byte> bytes) noexcept;

/// Empty if the bytes are no datagram of a sample, of this version.
std::optional<Datagram> parse(std::span<const std::byte> bytes) noexcept;

/// Takes the bodies of a packed datagram, one after the other, off its payload (behind the mask's words).
class PackedBodies {
 public:
  explicit PackedBodies(const Datagram& d)
      : rest_(d.payload), samples_(d.samples), bytes_each_(d.bytes_each) {}

  /// All are there, and behind equally long ones nothing else: next() may be called for each.
  bool sound() const noexcept;
  std::span<const std::byte> next() noexcept;

 private:
  std::span<const std::byte> rest_;
  std::size_t samples_;
  std::size_t bytes_each_;
};

void store_word(std::uint64_t word, std::byte* out) noexcept;
void store_length(std::size_t bytes, std::byte* out) noexcept;  ///< length_bytes
std::uint64_t load_word(const std::byte* from) noexcept;

/// The 64-bit sequence nearest to `reference` that has these low 32 bits; never below zero.
std::uint64_t widen_sequence(std::uint64_t reference, std::uint32_t low) noexcept;

}  // namespace sft::udp
