// Datagrams of RTPS 2.1 in the name of another participant's writer, in little-endian byte order.
#pragma once

#include <arpa/inet.h>
#include <dds/dds.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "sft_control.h"

namespace sft::test {

/// A sequence number that no honest writer reaches.
inline constexpr std::uint64_t far_ahead = std::uint64_t{1} << 40;

/// Returns the writers, with and without keys, that the participant may have. Writers can be guessed, because
/// Cyclone DDS gives its entities small numbers.
inline std::vector<dds_guid_t> guessed_writers(const dds_guid_t& participant) {
  constexpr std::uint8_t entities_max = 16, with_key = 0x02, without_key = 0x03;
  std::vector<dds_guid_t> writers;
  for (std::uint8_t number = 1; number <= entities_max; ++number) {
    for (const std::uint8_t kind : {with_key, without_key}) {
      dds_guid_t& writer = writers.emplace_back(participant);
      std::ranges::copy(std::array<std::uint8_t, 4>{0, 0, number, kind}, writer.v + 12);
    }
  }
  return writers;
}

class RtpsMessage {
 public:
  explicit RtpsMessage(const dds_guid_t& writer) : bytes_("RTPS") {
    bytes_.append("\x02\x01\x01\x10", 4);  // the version and the vendor
    bytes_.append(reinterpret_cast<const char*>(writer.v), 12);
    writer_.assign(reinterpret_cast<const char*>(writer.v) + 12, 4);
  }

  /// Adds a heartbeat, which says that the sample with that sequence number is the only one that the writer
  /// has.
  void add_heartbeat(std::uint64_t sequence) {
    add_submessage('\x07', '\x01', 28);
    add_sequence(sequence);
    add_sequence(sequence);
    add(std::uint32_t{0x0700'0000});  // the count of heartbeats
  }

  /// Adds a sample. The sample must be the last part of the message.
  void add_data(std::uint64_t sequence, const std::string& sample) {
    add_submessage('\x15', '\x05', 0, 16);
    add_sequence(sequence);
    bytes_ += plain_cdr + sample;
  }

  void add_record(std::uint64_t sequence, const sft_control_Record& record) {
    constexpr std::size_t head_bytes = 36;
    std::string sample(head_bytes, '\0');
    std::memcpy(sample.data(), record.participant, sizeof record.participant);
    std::memcpy(sample.data() + 16, &record.slot, sizeof record.slot);
    sample[20] = static_cast<char>(record.kind);
    sample[21] = static_cast<char>(record.version);
    std::memcpy(sample.data() + 24, &record.revision, sizeof record.revision);
    std::memcpy(sample.data() + 32, &record.body._length, sizeof record.body._length);
    sample.append(reinterpret_cast<const char*>(record.body._buffer), record.body._length);
    add_data(sequence, sample);
  }

  /// Adds a disposal of the participant in whose name the message is sent. The writer's entity is
  /// `entity_of_participants`.
  void add_end(const dds_guid_t& participant) {
    add_submessage('\x15', '\x0b', 0, 16);  // a submessage with inline QoS and a key
    add_sequence(1);
    constexpr std::uint16_t status_info = 0x71, end_of_list = 1, guid = 0x50, no_bytes = 0;
    add(status_info);
    add(std::uint16_t{4});
    bytes_.append("\x00\x00\x00\x03", 4);  // the status: disposed and unregistered
    add(end_of_list);
    add(no_bytes);
    bytes_.append("\x00\x03\x00\x00", 4);  // the encapsulation: a list of parameters
    add(guid);
    add(std::uint16_t{sizeof participant.v});
    bytes_.append(reinterpret_cast<const char*>(participant.v), sizeof participant.v);
    add(end_of_list);
    add(no_bytes);
  }
  static constexpr std::uint8_t entity_of_participants[4] = {0, 1, 0, 0xc2};

  /// The multicast ports of domain 0.
  enum class Port : std::uint16_t { discovery = 7400, data = 7401 };
  /// Sends the message by multicast on eth0.
  void send(Port port = Port::data) const {
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = inet_addr("239.255.0.1");
    ip_mreqn interface {};
    interface.imr_ifindex = static_cast<int>(if_nametoindex("eth0"));
    setsockopt(socket, IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface);
    const ssize_t sent =
        sendto(socket, bytes_.data(), bytes_.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    close(socket);
    if (sent < 0) throw std::runtime_error(std::string("RTPS: ") + std::strerror(errno));
  }

 private:
  inline static const std::string plain_cdr{"\x00\x01\x00\x00", 4};

  template <class Number>
  void add(const Number& number) {
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  void add_sequence(std::uint64_t number) {
    add(static_cast<std::uint32_t>(number >> 32));
    add(static_cast<std::uint32_t>(number));
  }
  /// Begins a submessage for any reader. `to_sequence` is the number of octets from that field to the
  /// sequence number. Only data has a sequence number; for other kinds `to_sequence` is 0.
  void add_submessage(char kind, char flags, std::uint16_t length, std::uint16_t to_sequence = 0) {
    bytes_ += {kind, flags};
    add(length);
    if (to_sequence != 0) {
      add(std::uint16_t{0});
      add(to_sequence);
    }
    bytes_ += std::string(4, '\0') + writer_;
  }

  std::string bytes_;
  std::string writer_;
};

}  // namespace sft::test
