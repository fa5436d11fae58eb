#include "tests/hostile/datagram_acts.h"

#include <arpa/inet.h>

#include <cstring>
#include <map>
#include <memory>

#include "tests/hostile/forged_control.h"
#include "tests/hostile/wire.h"
#include "udp_transport/wire/datagram.h"

namespace sft::hostile {

namespace {

using core::Endpoint;
using core::Role;
using udp::FirstHeader;

constexpr std::uint32_t channels_swept = 16;

/// Returns the header of a sample of two small fields that seems to come from this writer.
FirstHeader sample_header(const Endpoint& writer, const Endpoint& reader, std::uint32_t sequence,
                          std::uint16_t variant) {
  FirstHeader header;
  header.label = {static_cast<std::uint32_t>(writer.id), sequence, variant};
  header.mask = reader.request.mask_words.empty() ? 3 : reader.request.mask_words[0];
  header.total = 8;
  return header;
}
Bytes sample(const FirstHeader& header) {
  Bytes datagram = encoded(header, header.bytes());
  datagram.resize(datagram.size() + 8);
  return datagram;
}

struct Senders {
  ForgedControl forged_control;
  Sender sender;
};

using PairUse =
    std::function<void(const Sender&, const Endpoint& writer, const Endpoint& reader, const sockaddr_in& to)>;

/// Returns an act that at each tick calls `use` for each honest writer and each address of each honest
/// reader.
Act to_each_reader(PairUse use) {
  const auto senders = std::make_shared<Senders>();
  return {.begin = {}, .go_on = [senders, use = std::move(use)] {
            const auto readers = senders->forged_control.heard(Role::reader);
            for (const Endpoint& writer : senders->forged_control.heard(Role::writer)) {
              for (const Endpoint& reader : readers) {
                for (const sockaddr_in& to : addresses_of(reader)) use(senders->sender, writer, reader, to);
              }
            }
          }};
}

/// Returns an act like that of to_each_reader(), but which attacks each pair only once in half a second, so
/// that the pair can recover between two attacks.
Act once_to_each_reader(PairUse use) {
  constexpr int ticks_between = 50;
  const auto ticks = std::make_shared<std::map<std::pair<core::EndpointId, core::EndpointId>, int>>();
  return to_each_reader(
      [=](const Sender& sender, const Endpoint& writer, const Endpoint& reader, const sockaddr_in& to) {
        if ((*ticks)[{writer.id, reader.id}]++ % ticks_between == 0) use(sender, writer, reader, to);
      });
}

/// Returns an act that at each tick calls `use` for each honest writer and each address of its node.
Act to_each_writer(std::function<void(const Sender&, const Endpoint& writer, const sockaddr_in& to)> use) {
  const auto senders = std::make_shared<Senders>();
  return {.begin = {}, .go_on = [senders, use = std::move(use)] {
            for (const Endpoint& writer : senders->forged_control.heard(Role::writer)) {
              for (const sockaddr_in& to : addresses_of(writer)) use(senders->sender, writer, to);
            }
          }};
}

/// Returns the address of a host that does not exist, in a network in which no host exists.
sockaddr_in made_up_host(unsigned number) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(0x0A080001U + number);
  address.sin_port = htons(5000);
  return address;
}

}  // namespace

Act sequence_jumps(Target&) {
  return once_to_each_reader(
      [](const Sender& sender, const Endpoint& writer, const Endpoint& reader, const sockaddr_in& to) {
        sender.send(sample(sample_header(writer, reader, 0x7000'0000, 60'000)), to);
      });
}

/// Sends three samples with sequences far ahead, one after the other and also in a channel, so that each
/// sample is confirmed by the next.
Act sequence_jumps_confirmed(Target&) {
  return once_to_each_reader(
      [](const Sender& sender, const Endpoint& writer, const Endpoint& reader, const sockaddr_in& to) {
        for (std::uint16_t i = 0; i < 3; ++i) {
          FirstHeader header =
              sample_header(writer, reader, 0x7000'0000U + i, static_cast<std::uint16_t>(60'000 + i));
          sender.send(sample(header), to);
          header.flags = udp::channel_follows;
          header.channel = {1, 5, far_future / 2 + i};
          sender.send(sample(header), to);
        }
      });
}

Act heartbeats_from_the_far_future(Target&) {
  return once_to_each_reader(
      [](const Sender& sender, const Endpoint& writer, const Endpoint&, const sockaddr_in& to) {
        for (std::uint32_t channel = 1; channel <= channels_swept; ++channel) {
          const udp::Heartbeat heartbeat{
              static_cast<std::uint32_t>(writer.id), channel, 9, far_future, far_future, 0};
          sender.send(encoded(heartbeat, udp::heartbeat_bytes), to);
        }
      });
}

Act samples_of_sixteen_megabytes(Target&) {
  return once_to_each_reader(
      [](const Sender& sender, const Endpoint& writer, const Endpoint& reader, const sockaddr_in& to) {
        for (std::uint16_t i = 0; i < 40; ++i) {
          FirstHeader header =
              sample_header(writer, reader, 1'000'000U + i, static_cast<std::uint16_t>(60'000 + i));
          header.flags = udp::channel_follows;
          header.channel = {1, 0, 1000U + i};
          header.total = 16U << 20;
          sender.send(sample(header), to);
        }
      });
}

Act begun_samples(Target&) {
  return once_to_each_reader(
      [](const Sender& sender, const Endpoint& writer, const Endpoint& reader, const sockaddr_in& to) {
        for (std::uint16_t i = 0; i < 4096; ++i) {
          FirstHeader header = sample_header(writer, reader, 1'000'000U + i, static_cast<std::uint16_t>(i));
          header.flags = udp::channel_follows;
          header.channel = {1, 0, 1U + i};
          header.total = 1000;
          sender.send(sample(header), to);
        }
      });
}

Act swept_acks(Target&) {
  const auto next = std::make_shared<std::uint64_t>(1);
  return to_each_writer([next](const Sender& sender, const Endpoint& writer, const sockaddr_in& to) {
    for (int i = 0; i < 20; ++i, *next += 3) {
      for (std::uint32_t channel = 1; channel <= 3; ++channel) {
        const udp::Ack ack{static_cast<std::uint32_t>(writer.id), channel, *next};
        sender.send(encoded(ack, ack.bytes()), to);
      }
    }
  });
}

Act marks_of_made_up_senders(Target&) {
  constexpr unsigned hosts = 300;
  const auto spoofer = std::make_shared<Spoofer>();
  return to_each_reader([spoofer](const Sender&, const Endpoint&, const Endpoint&, const sockaddr_in& to) {
    for (unsigned host = 0; host < hosts; host += 10) {
      const udp::FlowMark mark{
          .flow = host, .port = 5001, .position = 1000, .datagrams = 10, .sent_at_ns = 1};
      spoofer->send(encoded(mark, udp::mark_bytes),
                    made_up_host(host + static_cast<unsigned>(to.sin_port % 10)), to);
    }
  });
}

Act marks_for_many_ports(Target&) {
  const auto port = std::make_shared<std::uint16_t>(20'000);
  return to_each_reader(
      [port](const Sender& sender, const Endpoint&, const Endpoint&, const sockaddr_in& to) {
        for (int i = 0; i < 20; ++i) {
          const udp::FlowMark mark{
              .flow = *port, .port = ++*port, .position = 1000, .datagrams = 10, .sent_at_ns = 1};
          sender.send(encoded(mark, udp::mark_bytes), to);
        }
      });
}

Act group_offers(Target& target) {
  return to_each_reader([&random = target.random](const Sender& sender, const Endpoint& writer,
                                                  const Endpoint&, const sockaddr_in& to) {
    for (std::uint32_t group = 0; group < 4; ++group) {
      const udp::GroupOffer offer{
          .writer = static_cast<std::uint32_t>(writer.id),
          .group = group + 1,
          .member = 1,
          .port = 9,
          .address = udp::private_groups | static_cast<std::uint32_t>(random() & 0xffff),
          .channel = group % 2,
          .ahead = static_cast<std::int64_t>(random() >> 2)};
      sender.send(encoded(offer, udp::group_offer_bytes), to);
    }
  });
}

Act group_reports(Target&) {
  return to_each_writer([](const Sender& sender, const Endpoint& writer, const sockaddr_in& to) {
    for (std::uint32_t group = 0; group < 4; ++group) {
      const udp::GroupReport report{static_cast<std::uint32_t>(writer.id), group, group, far_future};
      sender.send(encoded(report, udp::group_report_bytes), to);
    }
  });
}

Act garbage(Target& target) {
  return to_each_reader([&random = target.random](const Sender& sender, const Endpoint&, const Endpoint&,
                                                  const sockaddr_in& to) {
    Bytes datagram(1 + random() % 1400);
    for (std::byte& byte : datagram) byte = static_cast<std::byte>(random());
    for (int i = 0; i < 20; ++i) {
      datagram[0] = static_cast<std::byte>(random());
      sender.send(datagram, to);
    }
  });
}

/// Sends random datagrams to the ports of discovery. Half of the datagrams begin like messages of DDS.
Act garbage_for_discovery(Target& target) {
  const auto sender = std::make_shared<Sender>();
  return {.begin = {}, .go_on = [sender, &random = target.random] {
            for (int i = 0; i < 50; ++i) {
              Bytes datagram(20 + random() % 400);
              for (std::byte& byte : datagram) byte = static_cast<std::byte>(random());
              if (i % 2 == 0) std::memcpy(datagram.data(), "RTPS\2\1\1\20", 8);
              const std::uint16_t port = static_cast<std::uint16_t>(7400 + random() % 30);
              sender->send(datagram, to_port(inet_addr("239.255.0.1"), port));
              sender->send(datagram,
                           to_port(htonl(0x0A4E0001U + static_cast<std::uint32_t>(random() % 2)), port));
            }
          }};
}

}  // namespace sft::hostile
