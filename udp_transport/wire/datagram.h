// Encodes and decodes the headers of SFT datagrams (wire_format.md). Decoding checks all lengths. Uses no
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
// The lengths of headers of samples with a mask of eight bytes, which is the last field. A mask less than
// 2^16 takes only two bytes. This includes all masks of most message types.
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
/// The limits of variants and offsets in a following datagram. Greater values need a far datagram.
inline constexpr std::uint32_t near_variants_end = 1 << 8;
inline constexpr std::uint32_t near_offsets_end = 1 << 24;
inline constexpr std::size_t datagram_bytes_max = 65507;  ///< the longest UDP payload over IPv4
inline constexpr std::size_t datagram_bytes_min = 548;  ///< every IPv4 path carries a payload of this length

enum class DatagramKind : std::uint8_t {
  first = 1,      ///< the first datagram of a sample
  following = 2,  ///< a later part of a body, with a short header for limited values
  /// A writer reports the samples of a channel that it has sent and still keeps.
  heartbeat = 3,
  ack = 4,          ///< a reader reports the samples that it has received in a channel, and the missing parts
  packed = 5,       ///< several whole small samples, with consecutive sequences and ordinals
  group_offer = 6,  ///< a writer offers a process the multicast group to which it sends its samples
  group_report = 7,  ///< a member reports the last sample that it has received by a multicast group
  mark = 8,          ///< a flow mark: a sender reports how much it has sent to a socket so far
  report = 9,        ///< the receiver answers a flow mark, and says how much may be under way
  whole = 10,        ///< a sample in a channel that fits into this datagram, with a short header
  group_probe = 11,  ///< sent to a multicast group between samples, so that members report its arrival
  single = 12,  ///< a sample in no channel or group that fits into this datagram; read as a first datagram
  far = 13,     ///< any later part of a body; has the same content as a following datagram
};

/// Returns true for acks and reports, which receivers send. Writers send all other kinds.
constexpr bool is_answer(DatagramKind kind) {
  return kind == DatagramKind::ack || kind == DatagramKind::report || kind == DatagramKind::group_report;
}

/// Returns true for datagrams that contain samples or parts of samples.
constexpr bool is_of_sample(DatagramKind kind) {
  return kind == DatagramKind::first || kind == DatagramKind::following || kind == DatagramKind::far ||
         kind == DatagramKind::packed || kind == DatagramKind::whole || kind == DatagramKind::single;
}

/// A flag of a first datagram: the mask field is a hash, and the mask's words are directly before the
/// payload.
inline constexpr std::uint8_t mask_words_follow = 1;
/// A flag: the sample passed a gate for a maximum rate or conditions, and `rate` directly follows the
/// header.
inline constexpr std::uint8_t rate_follows = 2;
inline constexpr std::size_t rate_bytes = 8;
/// A flag: the sample is for one late reader only, and `history` follows the header and the rate, if any.
inline constexpr std::uint8_t history_follows = 4;
inline constexpr std::size_t history_bytes = 16;
/// A flag: the sample is sent reliably in a channel, and `channel` follows the header, rate and history, if
/// any.
inline constexpr std::uint8_t channel_follows = 8;
inline constexpr std::size_t channel_bytes = 16;
/// The limits of a whole datagram. It contains a variant less than `whole_variants_end`, a channel's number
/// modulo `whole_channels_end`, and 32 bits each of the sequence and the ordinal.
inline constexpr std::uint32_t whole_variants_end = 1 << 10;
inline constexpr std::uint32_t whole_channels_end = 1 << 11;
/// A flag: the sample is sent to a multicast group, and `group` is the last field before the mask's words.
inline constexpr std::uint8_t group_follows = 64;
inline constexpr std::size_t group_bytes = 16;
/// A flag: the mask is the union of the masks of several readers. The sample is for each reader whose mask
/// is contained in this union.
inline constexpr std::uint8_t merged_masks = 128;
/// The range 239.255.0.0/16, which RFC 2365 leaves free for local use. All groups have addresses in this
/// range. All datagrams to groups are sent to one port, which DDS uses in no domain.
inline constexpr std::uint32_t private_groups = 0xEFFF0000;
inline constexpr std::uint16_t group_port = 22155;
inline constexpr std::size_t group_offer_bytes = 32;
inline constexpr std::size_t group_report_bytes = 24;
inline constexpr std::size_t group_probe_bytes = 24;
/// A flag of a packed datagram: the length of each sample precedes the sample. Without this flag, all
/// samples have the same length.
inline constexpr std::uint8_t lengths_follow = 16;
inline constexpr std::size_t length_bytes = 2;
inline constexpr std::size_t packed_samples_max = 256;
/// A flag: the mask has two bytes. The flag exists only on the wire, since the value of the mask determines
/// it.
inline constexpr std::uint8_t narrow_mask = 32;
inline constexpr std::size_t heartbeat_bytes = 32;
inline constexpr std::size_t ack_header_bytes = 24;
inline constexpr std::size_t missing_bytes = 12;
inline constexpr std::size_t mark_bytes = 40;
/// A report is not longer than the flow mark that it answers.
inline constexpr std::size_t report_bytes = 40;
/// The maximum number of missing parts in an ack, so that every path carries the ack.
inline constexpr std::size_t missing_max = (datagram_bytes_min - ack_header_bytes) / missing_bytes;

/// The maximum ordinal. It is so small that no sum with an ordinal overflows.
inline constexpr std::uint64_t ordinal_max = std::uint64_t{1} << 62;

/// Names one encoding of one sample. All datagrams of that encoding have this label. Another encoding can
/// get the same label only after a long time.
struct SampleLabel {
  std::uint32_t writer = 0;    ///< low half of the writer's id
  std::uint32_t sequence = 0;  ///< low half of the sequence
  std::uint16_t variant = 0;   ///< the writer's number for the mask (VariantDirectory)
  friend bool operator==(const SampleLabel&, const SampleLabel&) = default;
};

/// The values of a sample that passed a gate at its writer (core/seam/gate.h): the gate's maximum rate as a
/// period, or 0 if it has none, and the sample's number among those that passed the gate.
struct RateMark {
  std::uint32_t min_period_us = 0;
  std::uint32_t ordinal = 0;
  friend bool operator==(const RateMark&, const RateMark&) = default;
};

/// The late reader for which a sample is sent. A late reader first gets the samples that the writer had
/// retained.
struct HistoryMark {
  std::uint64_t reader = 0;  ///< the id of the reader
  std::uint64_t oldest = 0;  ///< the sequence of the first sample for the reader
  friend bool operator==(const HistoryMark&, const HistoryMark&) = default;
};

/// The position of a sample in a channel.
struct ChannelMark {
  std::uint32_t channel = 0;        ///< the writer's number for the channel
  std::uint32_t sequence_high = 0;  ///< high half of the sample's sequence
  std::uint64_t ordinal = 0;        ///< number of the sample in the channel, from 1 on
  /// Before encoding: true if the receiver knows the channel, so that the low bits of the channel's number
  /// suffice. After decoding: true if the datagram has only the low bits.
  bool in_short = false;
  friend bool operator==(const ChannelMark&, const ChannelMark&) = default;
};

/// The position of a sample in the sequence of samples that were sent to a multicast group.
struct GroupMark {
  std::uint32_t group = 0;          ///< the writer's number for the group
  std::uint32_t sequence_high = 0;  ///< high half of the sample's sequence
  std::uint64_t ordinal = 0;        ///< number of the sample in the group, from a random number on
  friend bool operator==(const GroupMark&, const GroupMark&) = default;
};

struct FirstHeader {
  SampleLabel label;
  std::uint8_t flags = 0;
  std::uint32_t total = 0;    ///< size of the body in bytes, without encapsulation
  std::uint64_t mask = 0;     ///< bits of the leaves, or FieldMask::hash() for types with more than 64 leaves
  std::int64_t stamp_ns = 0;  ///< time of publishing, by CLOCK_REALTIME
  RateMark rate{};            ///< valid if `flags` has rate_follows
  HistoryMark history{};      ///< valid if `flags` has history_follows
  ChannelMark channel{};      ///< valid if `flags` has channel_follows
  GroupMark group{};          ///< valid if `flags` has group_follows

  /// Returns the header's length in bytes with the optional fields that the flags announce, without the
  /// mask's words.
  std::size_t bytes() const { return at_group() + ((flags & group_follows) != 0 ? group_bytes : 0); }
  std::size_t at_group() const { return at_channel() + ((flags & channel_follows) != 0 ? channel_bytes : 0); }
  std::size_t at_channel() const {
    return at_history() + ((flags & history_follows) != 0 ? history_bytes : 0);
  }
  std::size_t at_history() const { return at_rate() + ((flags & rate_follows) != 0 ? rate_bytes : 0); }
  std::size_t at_rate() const { return first_header_bytes - mask_bytes_saved(mask); }
  /// These two functions return the lengths of the headers of a whole and of a single datagram, without the
  /// mask's words.
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
  FirstHeader first;             ///< the header of the first sample; its `total` is not sent
  std::uint16_t samples = 0;     ///< number of samples, 1 to packed_samples_max
  std::uint16_t bytes_each = 0;  ///< length of each body; 0 if and only if lengths_follow is set
};

// The following functions encode headers into `out`.
void encode(const FirstHeader& header, std::byte* out) noexcept;      ///< writes header.bytes() bytes
void encode(const FollowingHeader& header, std::byte* out) noexcept;  ///< writes header.bytes() bytes
void encode(const PackedHeader& header, std::byte* out) noexcept;     ///< writes header.first.bytes() bytes

/// Returns true if the short header of a whole datagram can express all fields of this header. The caller
/// must also check that the whole body fits into the datagram.
bool fits_in_short(const FirstHeader& header) noexcept;
/// Encodes the short header of a whole datagram into `out`. Writes header.bytes_in_short() bytes.
void encode_in_short(const FirstHeader& header, std::byte* out) noexcept;

/// Returns true if the header of a single datagram can express all fields of this header. The caller must
/// also check that the whole body fits into the datagram.
constexpr bool fits_in_single(const FirstHeader& header) { return (header.flags & ~merged_masks) == 0; }
/// Encodes the header of a single datagram into `out`. Writes header.bytes_in_single() bytes.
void encode_in_single(const FirstHeader& header, std::byte* out) noexcept;

/// Returns the header of the sample that follows the first one by `samples` samples, with the given total.
/// Sequences and ordinals are consecutive.
FirstHeader header_behind(const FirstHeader& first, std::uint32_t samples, std::uint32_t total) noexcept;

/// Reports the samples of a channel by their ordinals. Samples in [first, end) were sent and can be sent
/// again. Samples with ordinals less than `first` cannot be sent again.
struct Heartbeat {
  std::uint32_t writer = 0;
  std::uint32_t channel = 0;
  std::uint16_t port = 0;  ///< port for acks, at the address from which the heartbeat comes
  std::uint64_t first = 0;
  std::uint64_t end = 0;
  std::uint32_t waiting = 0;  ///< number of samples from `end` on that were published but not sent yet
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
  std::uint64_t next = 0;  ///< an ordinal; samples with lower ordinals are not requested any more
  std::array<Missing, missing_max> missing{};
  std::size_t missing_count = 0;

  std::span<const Missing> parts() const { return {missing.data(), missing_count}; }
  std::size_t bytes() const { return ack_header_bytes + missing_count * missing_bytes; }
};

/// A flow mark, which requests a report. It says how much all writers of the sending process together have
/// sent to the receiver's socket.
struct FlowMark {
  std::uint32_t flow = 0;       ///< the sender's number for the receiver's socket
  std::uint16_t port = 0;       ///< port for the report, at the address from which the mark comes
  std::uint64_t position = 0;   ///< number of bytes that were sent before the flow mark
  std::uint32_t datagrams = 0;  ///< number of datagrams that were sent before the flow mark from its port
  std::int64_t sent_at_ns = 0;  ///< time when the flow mark was sent, by the sender's clock
  friend bool operator==(const FlowMark&, const FlowMark&) = default;
};

/// The receiver's answer to a flow mark. The report repeats most fields of the mark.
struct FlowReport {
  std::uint32_t flow = 0;
  std::uint64_t position = 0;
  /// Number of bytes that may be under way, as the receiving kernel counts them.
  std::uint32_t window_bytes = 0;
  std::uint32_t datagrams = 0;
  /// The number of these datagrams that arrived. Datagrams sent before the first flow mark count as arrived.
  std::uint32_t came = 0;
  /// The length in bytes of the longest datagram that came recently from the sender's address; 0 if it is
  /// not known.
  std::uint32_t longest = 0;
  std::int64_t sent_at_ns = 0;

  static constexpr std::size_t bytes() { return report_bytes; }
  friend bool operator==(const FlowReport&, const FlowReport&) = default;
};

/// Offers a multicast group to one member. If the samples of the group are also in a channel, a sample's
/// ordinal in the channel is its ordinal in the group plus `ahead`.
struct GroupOffer {
  std::uint32_t writer = 0;
  std::uint32_t group = 0;    ///< the writer's number for the group
  std::uint32_t member = 0;   ///< the member repeats this number in its reports
  std::uint16_t port = 0;     ///< port for reports, at the address from which the offer comes
  std::uint32_t address = 0;  ///< the IPv4 address of the group; 0: the member is not in the group any more
  /// The number of the channel that has the samples of the group; 0: they are in no channel, and are sent by
  /// best effort.
  std::uint32_t channel = 0;
  std::int64_t ahead = 0;
  friend bool operator==(const GroupOffer&, const GroupOffer&) = default;
};

struct GroupReport {
  std::uint32_t writer = 0;
  std::uint32_t group = 0;
  std::uint32_t member = 0;
  /// The ordinal of the last sample that has come by the group; 0: the member asks the writer to repeat the
  /// offer.
  std::uint64_t heard = 0;

  static constexpr std::size_t bytes() { return group_report_bytes; }
  friend bool operator==(const GroupReport&, const GroupReport&) = default;
};

/// A datagram that is sent to the group itself. Each process to which the group was offered reports the
/// ordinal, as if a sample had come.
struct GroupProbe {
  std::uint32_t writer = 0;
  std::uint32_t group = 0;
  /// The ordinal of the last sample that was sent to the group. Until a sample is sent, the first sample's
  /// ordinal minus 1.
  std::uint64_t ordinal = 0;
  friend bool operator==(const GroupProbe&, const GroupProbe&) = default;
};

// The following functions encode whole datagrams into `out`.
void encode(const GroupOffer& offer, std::byte* out) noexcept;     ///< writes group_offer_bytes bytes
void encode(const GroupReport& report, std::byte* out) noexcept;   ///< writes group_report_bytes bytes
void encode(const GroupProbe& probe, std::byte* out) noexcept;     ///< writes group_probe_bytes bytes
void encode(const Heartbeat& heartbeat, std::byte* out) noexcept;  ///< writes heartbeat_bytes bytes
void encode(const Ack& ack, std::byte* out) noexcept;              ///< writes ack.bytes() bytes
void encode(const FlowMark& mark, std::byte* out) noexcept;        ///< writes mark_bytes bytes
void encode(const FlowReport& report, std::byte* out) noexcept;    ///< writes report_bytes bytes

/// A received datagram of a sample. Its header is well-formed, but the values in it are not verified.
struct Datagram {
  DatagramKind kind{};
  /// The header. A whole datagram has the same fields as a first datagram, except that its total includes
  /// the mask's words.
  FirstHeader first;
  std::uint32_t offset = 0;            ///< offset of the payload in the body; 0 in a first datagram
  std::uint16_t samples = 0;           ///< number of samples of a packed datagram
  std::uint16_t bytes_each = 0;        ///< length of each sample of a packed datagram; 0: the lengths differ
  std::span<const std::byte> payload;  ///< begins with the mask's words if the flag mask_words_follow is set

  const SampleLabel& label() const { return first.label; }
};

/// A following or far datagram. These are by far the most frequent ones.
struct Following {
  SampleLabel label;
  std::uint32_t offset = 0;  ///< offset of the payload in the body
  std::span<const std::byte> payload;
};

/// The result of decode() for bytes that are no well-formed datagram of this version.
struct Malformed {
  std::optional<DatagramKind> kind;  ///< the kind in the header; empty if it is no valid kind
};

/// Any answer of a receiver to a datagram of this process.
using Answer = std::variant<Ack, FlowReport, GroupReport>;

/// A datagram of any kind. The alternative Datagram stands for a first, single, packed or whole datagram.
using AnyDatagram =
    std::variant<Malformed, Following, Datagram, Heartbeat, FlowMark, GroupOffer, GroupProbe, Answer>;

/// Decodes a datagram according to its kind. The result refers to `bytes`.
AnyDatagram decode(std::span<const std::byte> bytes) noexcept;

/// Returns the bodies of a packed datagram one after the other. The mask's words must have been removed from
/// its payload.
class PackedBodies {
 public:
  explicit PackedBodies(const Datagram& d)
      : rest_(d.payload), samples_(d.samples), bytes_each_(d.bytes_each) {}

  /// Returns true if the payload has all bodies completely, and no further bytes if they have equal lengths.
  /// next() may be called only in this case, and once for each body.
  bool sound() const noexcept;
  std::span<const std::byte> next() noexcept;

 private:
  std::span<const std::byte> rest_;
  std::size_t samples_;
  std::size_t bytes_each_;
};

void store_word(std::uint64_t word, std::byte* out) noexcept;
void store_length(std::size_t bytes, std::byte* out) noexcept;  ///< writes length_bytes bytes
std::uint64_t load_word(const std::byte* from) noexcept;

/// Returns the 64-bit sequence nearest to `reference` that has these low 32 bits. The result does not wrap
/// around below zero.
std::uint64_t widen_sequence(std::uint64_t reference, std::uint32_t low) noexcept;

}  // namespace sft::udp
