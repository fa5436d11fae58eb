// Hostile datagrams are parsed and reassembled. The samples that result are decoded as a subscriber decodes
// them. Then the same datagrams are sent to honest streams, which have to deliver samples again within a
// second of simulated time.
//
// The input consists of datagrams. Three bytes precede each: the action, and the datagram's length (u16,
// little-endian).
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "sft/detail/decode.h"
#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/arrivals.h"
#include "tests/unit/udp/live_streams.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/flow/flow_window.h"
#include "udp_transport/flow/receive_shares.h"
#include "udp_transport/receive/reassembly.h"

namespace {

using namespace sft;
using namespace sft::detail;
using udp::test::fields;
using udp::test::Image;
using udp::test::type_support;
using udp::test::Wide;

constexpr core::EndpointId image_writer = 0x1'0000'0001;
constexpr core::EndpointId wide_writer = 0x1'0000'0002;

/// Returns a selection whose bodies have the same form as those of a whole image.
Selection every_third_byte() {
  const TypeSupport& type = type_support<Image>();
  return type.closed(type.parse_selection("name, data[::3]").value());
}

std::vector<udp::Stream> streams() {
  return {{image_writer,
           &type_support<Image>(),
           0,
           {fields<Image>("*"), fields<Image>("data"), fields<Image>(""), every_third_byte()},
           true},
          {wide_writer, &type_support<Wide>(), 400, {fields<Wide>("*"), fields<Wide>("first, seventh")}}};
}

/// The bits of the action, which precedes each datagram. The upper four bits are the time that passes.
/// change_streams together with of_wide_writer changes the first stream between reliable and best-effort.
/// change_streams alone removes all streams for a moment.
constexpr std::uint8_t plausible = 1, first = 2, of_wide_writer = 4, change_streams = 8, time_shift = 4;

constexpr std::uint32_t channels = 8;

/// Returns one of a few ordinals, so that datagrams share ordinals, or one of the largest possible ordinals.
std::uint64_t ordinal_of(std::uint8_t number, std::uint8_t which) {
  return which % 4 == 3 ? udp::ordinal_max - number % 64U : 1U + number % 64U;
}

std::vector<std::byte> to_bytes(std::span<const std::uint8_t> bytes) {
  std::vector<std::byte> d(bytes.size());
  std::transform(bytes.begin(), bytes.end(), d.begin(),
                 [](std::uint8_t b) { return static_cast<std::byte>(b); });
  return d;
}

/// Turns `d` into a packed datagram of some samples. All bytes of `d` are used.
void make_packed(udp::FirstHeader header, const FieldMask& mask, std::vector<std::byte>& d) {
  const auto byte = [&](std::size_t i) { return std::to_integer<std::size_t>(d[i]); };
  // Packed datagrams must not be sent to groups, so some of these are malformed.
  const bool forbidden = byte(14) % 16 == 0;
  header.flags &= udp::mask_words_follow | udp::channel_follows |
                  (forbidden ? udp::group_follows | udp::merged_masks : 0);
  const bool words = (header.flags & udp::mask_words_follow) != 0;
  const std::size_t head = header.bytes() + (words ? mask.words() * sizeof(std::uint64_t) : 0);
  if (d.size() <= head) return;
  const std::size_t samples = 1 + byte(12) % 8;
  std::size_t each = byte(13) % 2 == 0 ? (d.size() - head) / samples : 0;
  if (each == 0) header.flags |= udp::lengths_follow;
  if (each != 0) d.resize(head + samples * each);
  for (std::size_t at = head; each == 0 && at + udp::length_bytes < d.size();
       at += udp::length_bytes + byte(at))
    udp::store_length(byte(at), &d[at]);
  encode(udp::PackedHeader{header, static_cast<std::uint16_t>(samples), static_cast<std::uint16_t>(each)},
         d.data());
  for (std::size_t i = 0; words && i < mask.words(); ++i)
    udp::store_word(mask.word(i), &d[header.bytes() + 8 * i]);
}

/// Turns the bytes into a control datagram of one of a few channels and groups.
bool make_plausible_control(std::uint32_t writer, std::vector<std::byte>& d) {
  const auto byte = [&](std::size_t i) { return std::to_integer<std::uint8_t>(d[i]); };
  const std::uint32_t number = (byte(12) | byte(13) << 8) % 1024U;
  const auto become = [&](std::size_t bytes, const auto& what) {
    if (d.size() < bytes) return false;
    d.resize(bytes);
    encode(what, d.data());
    return true;
  };
  if (d.size() < udp::heartbeat_bytes) return false;
  const std::uint64_t begin = ordinal_of(byte(16), byte(17));
  const std::uint32_t channel = byte(8) % (channels + 1), group = 1U + byte(9) % 3U;
  switch (byte(0) % 8) {
    case 0:
      return become(udp::heartbeat_bytes, udp::Heartbeat{writer, 1U + byte(8) % channels, 7, begin,
                                                         std::min(begin + byte(24) % 64U, udp::ordinal_max)});
    case 1:
      return become(udp::report_bytes, udp::FlowReport{0, number * 1000U, byte(16) * 1000U, byte(20),
                                                       byte(24), byte(28) * 16U, byte(31)});
    case 2:
      return become(udp::group_offer_bytes,
                    udp::GroupOffer{writer, group, 1, 7, byte(10) == 0 ? 0 : udp::private_groups + group,
                                    channel, byte(16) % 32 - 8});
    case 4:
      return become(udp::group_probe_bytes,
                    udp::GroupProbe{writer, group, std::max<std::uint64_t>(begin, 1)});
    case 3:
      return become(udp::mark_bytes,
                    udp::FlowMark{byte(8) % 4U, 7, number * 1000U, byte(16), byte(24) * 1000});
    default:
      return false;
  }
}

/// Puts the sample into a channel, into a group, or into neither of them.
void put_in_place(udp::FirstHeader& header, const std::vector<std::byte>& d) {
  const auto byte = [&](std::size_t i) { return std::to_integer<std::uint8_t>(d[i]); };
  if (byte(1) >= 128) {
    header.flags |= udp::channel_follows;
    header.channel = {1U + byte(3) % channels, 0, ordinal_of(byte(9), byte(10)), byte(11) % 2 == 0};
  } else if (byte(1) >= 64) {
    header.flags |= udp::group_follows;
    header.group = {1U + byte(3) % 3U, 0, ordinal_of(byte(9), byte(10))};
  }
}

/// Turns the bytes at the place of the header into the header of one of a few samples. So several datagrams
/// belong to the same sample.
void make_plausible(std::uint8_t action, std::vector<std::byte>& d, const std::vector<udp::Stream>& wanted) {
  const auto byte = [&](std::size_t i) { return std::to_integer<std::uint8_t>(d[i]); };
  const udp::Stream& stream = wanted[(action & of_wide_writer) != 0 ? 1 : 0];
  const udp::SampleLabel label{static_cast<std::uint32_t>(stream.writer), byte(8) % 8U,
                               // the variant 0 or a far variant
                               static_cast<std::uint16_t>(byte(2) % 2 * udp::near_variants_end)};
  const std::uint32_t number = (byte(12) | byte(13) << 8) % 1024U;
  if ((action & first) != 0 && make_plausible_control(label.writer, d)) return;
  if ((action & first) == 0 ||
      d.size() < udp::first_header_bytes + udp::rate_bytes + udp::channel_bytes + udp::group_bytes) {
    udp::encode(udp::FollowingHeader{label, number}, d.data());
    return;
  }
  const Selection& asked = stream.selections[byte(16) % stream.selections.size()];
  FieldMask mask = asked.mask();
  udp::FirstHeader header{label, static_cast<std::uint8_t>(byte(1) % 4), 0, 0, 0, {1, number}};
  if (byte(17) % 4 == 0) {
    header.flags |= udp::merged_masks;
    for (const Selection& other : stream.selections) mask |= other.mask();
    if (byte(18) % 2 == 0) mask = stream.type->closed(mask & stream.selections.back().mask());
  }
  header.mask = (header.flags & udp::merged_masks) != 0 ? mask.hash() : asked.what_hash();
  put_in_place(header, d);
  const bool words = (header.flags & udp::mask_words_follow) != 0;
  const std::size_t head = header.bytes() + (words ? mask.words() * sizeof(std::uint64_t) : 0);
  const bool whole = byte(14) % 2 == 0 && d.size() >= head;
  if (byte(15) % 4 == 0) return make_packed(header, mask, d);
  header.total = whole ? static_cast<std::uint32_t>(d.size() - head) : number;
  if (whole && byte(13) % 2 == 0 && udp::fits_in_single(header)) {
    udp::encode_in_single(header, d.data());
    d.resize(d.size() - (header.bytes() - header.bytes_in_single()));  // the total stays that of the header
    return;
  }
  const bool in_short = byte(13) % 2 == 0 && udp::fits_in_short(header);
  const std::size_t at_words = in_short ? header.bytes_in_short() : header.bytes();
  in_short ? udp::encode_in_short(header, d.data()) : udp::encode(header, d.data());
  if (whole) d.resize(d.size() - (header.bytes() - (in_short ? header.bytes_in_short() : header.bytes())));
  for (std::size_t i = 0; words && i < mask.words() && at_words + 8 * i + 8 <= d.size(); ++i) {
    udp::store_word(mask.word(i), &d[at_words + 8 * i]);
  }
}

template <class T>
void decode_all(const core::SampleBuffer& sample) {
  const SampleHeader& header = sample.header();
  SampleState state;
  state.body = sample.data + header.body_offset;
  state.body_bytes = header.body_bytes;
  state.index = sample.index();
  state.mask = &sample.mask;
  T value;
  // The body was validated before.
  if (decode(state, TypeTable<T>::type, &value) != WalkStatus::ok) std::abort();
}

/// Takes samples as two readers of the first stream do. The second reader takes only samples under the full
/// mask.
void read_in_order(udp::ArrivalWindow& window) {
  window.set_readers({1, 2});
  const FieldMask all = fields<Image>("*");
  for (const core::EndpointId reader : {1U, 2U}) {
    const auto accepts = [&](const core::SampleBuffer& s, std::uint64_t) {
      return reader == 1 || s.mask == all;
    };
    while (const core::SampleHandle sample = window.next(reader, accepts)) decode_all<Image>(*sample);
  }
  window.release();
}

void answer(udp::Reassembly& reassembly, udp::Reassembly::Time now) {
  reassembly.answer(now, [](const udp::SocketAddress&, const udp::Ack& ack) {
    std::vector<std::byte> bytes(ack.bytes());
    encode(ack, bytes.data());
    if (!udp::parse_as<udp::Ack>(bytes)) std::abort();
  });
  reassembly.report_groups([](const udp::SocketAddress&, const udp::GroupReport& report) {
    std::vector<std::byte> bytes(udp::group_report_bytes);
    encode(report, bytes.data());
    if (!udp::parse_as<udp::GroupReport>(bytes)) std::abort();
  });
}

/// Both ends of a flow. The sender sends as much as it may whenever a datagram arrives.
class Flow {
 public:
  void meet(std::span<const std::byte> datagram, udp::FlowWindow::Time now) {
    if (const auto mark = udp::parse_as<udp::FlowMark>(datagram))
      static_cast<void>(shares_.answer(*mark, {mark->flow, mark->port}, now));
    if (const auto report = udp::parse_as<udp::FlowReport>(datagram))
      static_cast<void>(window_.hear(*report, now));
    for (int i = 0; i < 8 && window_.room(udp::FlowWindow::Size::large, now) > 0; ++i)
      window_.sent(60'000, 41, now);
    static_cast<void>(window_.mark(now));
    if (window_.under_way() > window_.position() || window_.next_ready(now) < now) std::abort();
  }

 private:
  udp::FlowWindow window_{0, udp::FlowLimits{}};
  udp::ReceiveShares shares_{212'992};
};

/// Checks that all streams deliver samples again within a second after the last of these datagrams.
void check_that_streams_work_again(const std::vector<std::vector<std::byte>>& datagrams) {
  udp::test::LiveStreams streams;
  const auto pass = [&](int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) streams.pass_a_millisecond([] {});
  };
  pass(30);
  for (const std::vector<std::byte>& datagram : datagrams) {
    streams.receive(datagram);
    pass(1);
  }
  const auto quiet = streams.now();
  pass(1000);
  for (const udp::test::StreamKind kind : udp::test::all_stream_kinds) {
    if (streams.came_since(kind, quiet) == 0) std::abort();
  }
}

/// Returns true for one in 16 inputs. Simulating a second after each input would take too long.
bool is_chosen(std::span<const std::uint8_t> input) {
  unsigned sum = 0;
  for (const std::uint8_t byte : input) sum += byte;
  return sum % 16 == 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const udp::ReassemblyLimits limits{
      .sample_bytes = 64 << 10, .unfinished_bytes = 256 << 10, .parked_bytes = 16 << 10, .gaps = 64};
  udp::Reassembly reassembly(limits, core::BufferPool::make(1 << 20));
  std::vector<udp::Stream> wanted = streams();
  reassembly.set_streams(wanted);
  udp::Reassembly::Time now{};
  Flow flow;
  std::span<const std::uint8_t> input(data, size);
  const bool is_followed = is_chosen(input);
  std::vector<std::vector<std::byte>> all;
  while (input.size() >= 3) {
    const std::uint8_t action = input[0];
    const std::size_t bytes = std::min<std::size_t>(input[1] | input[2] << 8, input.size() - 3);
    now += std::chrono::milliseconds(10 * (action >> time_shift));
    if ((action & change_streams) != 0) {
      if ((action & of_wide_writer) != 0) {
        wanted[0].reliable = !wanted[0].reliable;
      } else {
        reassembly.set_streams({});
      }
      reassembly.set_streams(wanted);
    }
    reassembly.expire(now);
    std::vector<std::byte> datagram = to_bytes(input.subspan(3, bytes));
    if ((action & plausible) != 0 && bytes >= udp::far_header_bytes) make_plausible(action, datagram, wanted);
    if (is_followed) all.push_back(datagram);
    static_cast<void>(udp::parse_as<udp::Ack>(datagram));
    flow.meet(datagram, now);
    static_cast<void>(udp::parse_as<udp::GroupReport>(datagram));
    static_cast<void>(udp::parse_as<udp::GroupProbe>(datagram));
    const udp::Arrival arrival = udp::test::accept(reassembly, datagram, {now, 1});
    if (reassembly.groups().size() > 4 * wanted.size()) std::abort();
    std::vector<core::SampleHandle> samples(arrival.packed.begin(), arrival.packed.end());
    if (arrival.sample) samples.push_back(arrival.sample);
    for (const core::SampleHandle& sample : samples)
      arrival.stream == 0 ? decode_all<Image>(*sample) : decode_all<Wide>(*sample);
    if (udp::ArrivalWindow* window = reassembly.window(0)) read_in_order(*window);
    answer(reassembly, now);
    input = input.subspan(3 + bytes);
  }
  if (is_followed) check_that_streams_work_again(all);
  return 0;
}
