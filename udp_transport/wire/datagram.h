// The headers of SFT datagrams (wire_format.md), from structs to bytes and back. Bounds-checked; uses no
// clock, thread or I/O.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

namespace sft::udp {

inline constexpr std::uint8_t wire_version = 2;
// The lengths of headers of samples with a mask of eight bytes. The mask is the last field. A mask below
// 2^16 takes only two bytes, which is enough for all masks of most message types.
inline constexpr std::size_t first_header_bytes = 32;
inline constexpr std::size_t single_header_bytes = 28;
inline constexpr std::size_t wide_mask_bytes = 8;
inline constexpr std::size_t narrow_mask_bytes = 2;
constexpr bool is_narrow(std::uint64_t mask) { return mask < std::uint64_t{1} << (8 * narrow_mask_bytes); }
/// Returns the number of bytes that a narrow mask saves in a header; 0 for a mask that needs eight bytes.
constexpr std::size_t mask_bytes_saved(std::uint64_t mask) {
  return is_narrow(mask) ? wide_mask_bytes - narrow_mask_bytes : 0;
}
inline constexpr std::size_t following_header_bytes = 13;
inline constexpr std::size_t far_header_bytes = 16;
/// The limits of variants and offsets in a following datagram. Greater ones need a far datagram.
inline constexpr std::uint32_t near_variants_end = 1 << 8;
inline constexpr std::uint32_t near_offsets_end = 1 << 24;
inline constexpr std::size_t datagram_bytes_max = 65507;  ///< the longest UDP payload over IPv4
inline constexpr std::size_t datagram_bytes_min = 548;    ///< a payload of this length passes every IPv4 path

enum class DatagramKind : std::uint8_t {
  first = 1,      ///< the first datagram of a sample
  following = 2,  ///< a later part of a body, within reach of a short header
  /// A writer reports the samples of a channel that it has sent, and those that it still has.
  heartbeat = 3,
  ack = 4,           ///< a reader reports what it has received in a channel, and what is missing
  packed = 5,        ///< whole small samples, whose sequences and ordinals follow one another
  group_offer = 6,   ///< a writer tells a process the multicast group in which it sends its samples
  group_report = 7,  ///< a member reports what it has received by a group
  mark = 8,          ///< sent between samples: the amount that was sent to a socket so far
  report = 9,        ///< the receiver answers a mark, and says how much may be under way
  whole = 10,        ///< a sample in a channel that fits into this datagram, with a short header
  group_probe = 11,  ///< sent to a multicast group between samples: members report that they received it
  single = 12,       ///< a sample without any marks that fits into this datagram; read as a first datagram
  far = 13,          ///< any later part of a body; has the same content as a following datagram
};

/// Returns true for acks and reports, which answer what this process has sent. All other kinds come from a
/// writer.
constexpr bool is_answer(DatagramKind kind) {
  return kind == DatagramKind::ack || kind == DatagramKind::report || kind == DatagramKind::group_report;
}

/// Returns true for datagrams that carry samples or parts of them.
constexpr bool is_of_sample(DatagramKind kind) {
  return kind == DatagramKind::first || kind == DatagramKind::following || kind == DatagramKind::far ||
         kind == DatagramKind::packed || kind == DatagramKind::whole || kind == DatagramKind::single;
}

/// A flag of a first datagram: its mask field is a hash, and the mask's words stand right before the
/// payload.
inline constexpr std::uint8_t mask_words_follow = 1;
/// A flag: the sample passed a gate for a maximum rate, and `rate` stands right behind the header.
inline constexpr std::uint8_t rate_follows = 2;
inline constexpr std::size_t rate_bytes = 8;
/// A flag: the sample is for one late reader only, and `history` stands behind the rate.
inline constexpr std::uint8_t history_follows = 4;
inline constexpr std::size_t history_bytes = 16;
/// A flag: the sample is sent reliably in a channel, and `channel` stands behind the history.
inline constexpr std::uint8_t channel_follows = 8;
inline constexpr std::size_t channel_bytes = 16;
/// The limits of a whole datagram. It has room for variants below `whole_variants_end`, for a channel's
/// number modulo `whole_channels_end`, and for 32 bits of sequence and ordinal.
inline constexpr std::uint32_t whole_variants_end = 1 << 10;
inline constexpr std::uint32_t whole_channels_end = 1 << 11;
/// A flag: the sample is sent to a multicast group, and `group` stands behind the channel.
inline constexpr std::uint8_t group_follows = 64;
inline constexpr std::size_t group_bytes = 16;
/// A flag: the mask is the union of the masks of several readers. The sample is for each reader whose mask
/// is contained in it.
inline constexpr std::uint8_t merged_masks = 128;
/// The range 239.255.0.0/16, which RFC 2365 leaves free for local use: all groups are in it. All datagrams
/// to groups go to one port, which DDS uses in no domain.
inline constexpr std::uint32_t private_groups = 0xEFFF0000;
inline constexpr std::uint16_t group_port = 22155;
inline constexpr std::size_t group_offer_bytes = 32;
inline constexpr std::size_t group_report_bytes = 24;
inline constexpr std::size_t group_probe_bytes = 24;
/// A flag of a packed datagram: the length of each sample precedes it. Without this flag all samples are
/// equally long.
inline constexpr std::uint8_t lengths_follow = 16;
inline constexpr std::size_t length_bytes = 2;
inline constexpr std::size_t packed_samples_max = 256;
/// A flag: the mask has two bytes. It exists only on the wire, since the value of the mask implies it.
inline constexpr std::uint8_t narrow_mask = 32;
inline constexpr std::size_t heartbeat_bytes = 32;
inline constexpr std::size_t ack_header_bytes = 24;
inline constexpr std::size_t missing_bytes = 12;
inline constexpr std::size_t mark_bytes = 40;
inline constexpr std::size_t report_bytes = 40;  ///< a report is no longer than the mark that it answers
/// The largest number of missing parts for which an ack passes every path.
inline constexpr std::size_t missing_max = (datagram_bytes_min - ack_header_bytes) / missing_bytes;

/// The limit of ordinals, so that no sum with an ordinal overflows.
inline constexpr std::uint64_t ordinal_max = std::uint64_t{1} << 62;

/// Names one encoding of one sample. All datagrams of that encoding carry this label. No other encoding has
/// the same label until long afterwards.
struct SampleLabel {
  std::uint32_t writer = 0;    ///< low half of the writer's id
  std::uint32_t sequence = 0;  ///< low half of the sequence
  std::uint16_t variant = 0;   ///< the writer's number for the mask
  friend bool operator==(const SampleLabel&, const SampleLabel&) = default;
};

/// The mark of a sample that passed a gate at its writer (core/seam/gate.h). It has the gate's maximum rate
/// as a period, or 0 if the gate has no maximum rate, and the sample's number among those that passed the
/// gate.
struct RateMark {
  std::uint32_t min_period_us = 0;
  std::uint32_t ordinal = 0;
  friend bool operator==(const RateMark&, const RateMark&) = default;
};

/// The late reader that a sample is for. Such a reader is first sent the samples that its writer retained.
struct HistoryMark {
  std::uint64_t reader = 0;  ///< the id of the reader
  std::uint64_t oldest = 0;  ///< the sequence of the first sample that the reader is sent
  friend bool operator==(const HistoryMark&, const HistoryMark&) = default;
};

/// The place of a sample in a channel.
struct ChannelMark {
  std::uint32_t channel = 0;        ///< the writer's number for the channel
  std::uint32_t sequence_high = 0;  ///< high half of the sample's sequence
  std::uint64_t ordinal = 0;        ///< counts the samples in the channel, from 1
  /// Before encoding: true if the receiver knows the channel, so that the low bits of its number are
  /// enough. After decoding: true if the datagram has only the low bits.
  bool in_short = false;
  friend bool operator==(const ChannelMark&, const ChannelMark&) = default;
};

/// The place of a sample among those that were sent to a group.
struct GroupMark {
  std::uint32_t group = 0;          ///< the writer's number for the group
  std::uint32_t sequence_high = 0;  ///< high half of the sample's sequence
  std::uint64_t ordinal = 0;  ///< counts the samples that were sent to the group, from a random number on
  friend bool operator==(const GroupMark&, const GroupMark&) = default;
};

struct FirstHeader {
  SampleLabel label;
  std::uint8_t flags = 0;
  std::uint32_t total = 0;    ///< bytes of the body, without encapsulation
  std::uint64_t mask = 0;     ///< bits of the leaves, or FieldMask::hash() for types with more than 64 leaves
  std::int64_t stamp_ns = 0;  ///< time of publishing, by CLOCK_REALTIME
  RateMark rate{};            ///< valid if `flags` has rate_follows
  HistoryMark history{};      ///< valid if `flags` has history_follows
  ChannelMark channel{};      ///< valid if `flags` has channel_follows
  GroupMark group{};          ///< valid if `flags` has group_follows

  /// Returns the header's length with all marks that the flags announce, without the mask's words.
  std::size_t bytes() const { return at_group() + ((flags & group_follows) != 0 ? group_bytes : 0); }
  std::size_t at_group() const { return at_channel() + ((flags & channel_follows) != 0 ? channel_bytes : 0); }
  std::size_t at_channel() const {
    return at_history() + ((flags & history_follows) != 0 ? history_bytes : 0);
  }
  std::size_t at_history() const { return at_rate() + ((flags & rate_follows) != 0 ? rate_bytes : 0); }
  std::size_t at_rate() const { return first_header_bytes - mask_bytes_saved(mask); }
  /// Returns the lengths of the headers of a whole and of a single datagram, without the mask's words.
  std::size_t bytes_in_short() const { return at_rate(); }
  std::size_t bytes_in_single() const { return single_header_bytes - mask_bytes_saved(mask); }
};

struct FollowingHeader {
  SampleLabel label;
  std::uint32_t offset = 0;  ///< offset of the payload in the body

  bool is_near() const { return label.variant < near_variants_end && offset < near_offsets_end; }
  std::size_t bytes() const { return is_near() ? following_header_bytes : far_header_bytes; }
};

/// The fields that all samples of a packed datagram share.
struct PackedHeader {
  FirstHeader first;             ///< the header of the first sample; its total is not sent
  std::uint16_t samples = 0;     ///< number of samples, 1 to packed_samples_max
  std::uint16_t bytes_each = 0;  ///< length of each body; 0 if and only if lengths_follow is set
};

void encode(const FirstHeader& header, std::byte* out) noexcept;      ///< writes header.bytes()
void encode(const FollowingHeader& header, std::byte* out) noexcept;  ///< writes header.bytes()
void encode(const PackedHeader& header, std::byte* out) noexcept;     ///< writes header.first.bytes()

/// Returns true if a whole datagram can express all fields of this header. The datagram must also have room
/// for the whole body.
bool fits_in_short(const FirstHeader& header) noexcept;
void encode_in_short(const FirstHeader& header, std::byte* out) noexcept;  ///< writes bytes_in_short()

/// Returns true if a single datagram can express all fields of this header. The datagram must also have
/// room for the whole body.
constexpr bool fits_in_single(const FirstHeader& header) { return (header.flags & ~merged_masks) == 0; }
void encode_in_single(const FirstHeader& header, std::byte* out) noexcept;  ///< writes bytes_in_single()

/// Returns the header of the sample that comes `samples` samples after the first one. Sequences and
/// ordinals are consecutive.
FirstHeader header_behind(const FirstHeader& first, std::uint32_t samples, std::uint32_t total) noexcept;

/// The samples of a channel that a writer has. Samples in [first, end) were sent and can be sent again.
/// Samples before `first` cannot be sent again.
struct Heartbeat {
  std::uint32_t writer = 0;
  std::uint32_t channel = 0;
  std::uint16_t port = 0;  ///< acks go to this port, at the address that the heartbeat comes from
  std::uint64_t first = 0;
  std::uint64_t end = 0;
  std::uint32_t waiting = 0;  ///< number of samples from `end` on that were published, and will be sent
  friend bool operator==(const Heartbeat&, const Heartbeat&) = default;
};

/// A part of a sample that has not come: bytes [begin, end) of its body. If `begin` and `end` are equal, no
/// part of the sample has come yet, and its first datagram is requested.
struct Missing {
  std::uint32_t ordinal = 0;  ///< low half of the sample's ordinal
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  friend bool operator==(const Missing&, const Missing&) = default;
};

struct Ack {
  std::uint32_t writer = 0;
  std::uint32_t channel = 0;
  std::uint64_t next = 0;  ///< an ordinal; no sample before it is requested any more
  std::array<Missing, missing_max> missing{};
  std::size_t missing_count = 0;

  std::span<const Missing> parts() const { return {missing.data(), missing_count}; }
  std::size_t bytes() const { return ack_header_bytes + missing_count * missing_bytes; }
};

/// States how much all writers of the sending process have sent to the receiver's socket before this mark.
struct FlowMark {
  std::uint32_t flow = 0;       ///< the sender's number for the receiver's socket
  std::uint16_t port = 0;       ///< the report goes to this port, at the address that the mark comes from
  std::uint64_t position = 0;   ///< bytes that were sent before the mark
  std::uint32_t datagrams = 0;  ///< datagrams that were sent before the mark from its port
  std::int64_t sent_at_ns = 0;  ///< time when the mark was sent, by the sender's clock
  friend bool operator==(const FlowMark&, const FlowMark&) = default;
};

/// The receiver's answer to a mark. The report repeats most fields of the mark.
struct FlowReport {
  std::uint32_t flow = 0;
  std::uint64_t position = 0;
  std::uint32_t window_bytes = 0;  ///< bytes that may be under way, as the receiving kernel accounts them
  std::uint32_t datagrams = 0;
  /// The number of these datagrams that arrived. Datagrams sent before the first mark count as arrived.
  std::uint32_t came = 0;
  /// The length in bytes of the longest datagram that came recently from the sender's address; 0 if it is
  /// not known.
  std::uint32_t longest = 0;
  std::int64_t sent_at_ns = 0;
  friend bool operator==(const FlowReport&, const FlowReport&) = default;
};

/// Offers a multicast group to one member. If the samples of the group belong to a channel, too, an ordinal
/// in the channel is the ordinal in the group plus `ahead`.
struct GroupOffer {
  std::uint32_t writer = 0;
  std::uint32_t group = 0;    ///< the writer's number for the group
  std::uint32_t member = 0;   ///< the member repeats this number in its reports
  std::uint16_t port = 0;     ///< reports go to this port, at the address that the offer comes from
  std::uint32_t address = 0;  ///< the IPv4 address of the group; 0: the member is not in the group any more
  /// Number of the channel; 0: the samples are in no channel, and are sent by best effort.
  std::uint32_t channel = 0;
  std::int64_t ahead = 0;
  friend bool operator==(const GroupOffer&, const GroupOffer&) = default;
};

struct GroupReport {
  std::uint32_t writer = 0;
  std::uint32_t group = 0;
  std::uint32_t member = 0;
  /// The last ordinal that has come; 0: the member asks the writer to repeat the offer.
  std::uint64_t heard = 0;
  friend bool operator==(const GroupReport&, const GroupReport&) = default;
};

/// Sent to the group itself. Each process that was offered the group reports the ordinal as if a sample had
/// come.
struct GroupProbe {
  std::uint32_t writer = 0;
  std::uint32_t group = 0;
  /// Ordinal of the last sample that was sent to the group; before the first sample, the ordinal before it.
  std::uint64_t ordinal = 0;
  friend bool operator==(const GroupProbe&, const GroupProbe&) = default;
};

void encode(const GroupOffer& offer, std::byte* out) noexcept;     ///< writes group_offer_bytes
void encode(const GroupReport& report, std::byte* out) noexcept;   ///< writes group_report_bytes
void encode(const GroupProbe& probe, std::byte* out) noexcept;     ///< writes group_probe_bytes
void encode(const Heartbeat& heartbeat, std::byte* out) noexcept;  ///< writes heartbeat_bytes
void encode(const Ack& ack, std::byte* out) noexcept;              ///< writes ack.bytes()
void encode(const FlowMark& mark, std::byte* out) noexcept;        ///< writes mark_bytes
void encode(const FlowReport& report, std::byte* out) noexcept;    ///< writes report_bytes

/// A received datagram of a sample. Its header is well-formed, but the values in it are not verified.
struct Datagram {
  DatagramKind kind{};
  /// The header. A following datagram has only the label. A whole datagram has the same fields as a first
  /// one, but its total includes the mask's words.
  FirstHeader first;
  std::uint32_t offset = 0;            ///< offset of the payload in the body; 0 in a first datagram
  std::uint16_t samples = 0;           ///< number of samples of a packed datagram
  std::uint16_t bytes_each = 0;        ///< length of each sample of a packed datagram; 0: the lengths differ
  std::span<const std::byte> payload;  ///< begins with the mask's words if mask_words_follow is set

  const SampleLabel& label() const { return first.label; }
};

/// A following datagram, near or far. This is by far the most frequent kind.
struct Following {
  SampleLabel label;
  std::uint32_t offset = 0;  ///< offset of the payload in the body
  std::span<const std::byte> payload;
};

/// The result for bytes that are no well-formed datagram of this version.
struct Malformed {
  std::optional<DatagramKind> kind;  ///< the kind that the bytes name, if they name one
};

/// Any answer of a receiver to a datagram of this process.
using Answer = std::variant<Ack, FlowReport, GroupReport>;

/// A datagram of any kind. The alternative Datagram is a first, single, packed or whole one.
using AnyDatagram =
    std::variant<Malformed, Following, Datagram, Heartbeat, FlowMark, GroupOffer, GroupProbe, Answer>;

/// Reads the kind of a datagram, and then the datagram as one of that kind.
AnyDatagram decode(std::span<const std::byte> bytes) noexcept;

/// Takes the bodies of a packed datagram, one after the other, from its payload (behind the mask's words).
class PackedBodies {
 public:
  explicit PackedBodies(const Datagram& d)
      : rest_(d.payload), samples_(d.samples), bytes_each_(d.bytes_each) {}

  /// Returns true if all bodies are complete, and nothing follows bodies of equal length. Only then may
  /// next() be called, once for each body.
  bool sound() const noexcept;
  std::span<const std::byte> next() noexcept;

 private:
  std::span<const std::byte> rest_;
  std::size_t samples_;
  std::size_t bytes_each_;
};

void store_word(std::uint64_t word, std::byte* out) noexcept;
void store_length(std::size_t bytes, std::byte* out) noexcept;  ///< writes length_bytes
std::uint64_t load_word(const std::byte* from) noexcept;

/// Returns the 64-bit sequence nearest to `reference` that has these low 32 bits; never below zero.
std::uint64_t widen_sequence(std::uint64_t reference, std::uint32_t low) noexcept;

}  // namespace sft::udp
