// A program with SFT and one with Cyclone DDS alone, with default settings. Both have the same interface, so
// that each group measures both. SFT's nodes do not look for shared memory, since the hosts of this benchmark
// have a network of their own each, and one memory together.
#pragma once

#include <sft/sft.h>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <vector>

#include "bench/common/cyclone.h"
#include "bench/many/payload.h"

namespace sft::bench {

/// The fields that a reader asks for, by its number.
using Fields = std::function<std::string(std::size_t)>;

class SftMember {
  using Message = sensor_msgs::msg::PointCloud2;

 public:
  static constexpr const char* name = "SFT";

  class Writer {
   public:
    Writer(SftMember& member, const Payload& payload);
    bool serves(std::size_t readers) const { return sender_.serves(readers); }
    void write() { sender_.send(); }

   private:
    const Sender sender_;
  };

  /// Asks for all fields of clouds.
  class Reader {
   public:
    explicit Reader(SftMember& member);
    bool matched() const;

   private:
    Subscriber<Message> subscriber_;
  };

  /// Asks for some fields. The type of the publisher is known before.
  class MaskedReader {
   public:
    MaskedReader(SftMember& member, const Payload& payload, const std::function<void()>& arrived)
        : member_(member), payload_(payload), arrived_(arrived) {}

    /// From then on it has no fields but these.
    void ask_for(const std::string& fields);
    /// REQUIRES: it has asked.
    bool matched() const;

   private:
    SftMember& member_;
    const Payload& payload_;
    const std::function<void()> arrived_;
    std::optional<DynamicSubscriber> subscriber_;
  };

  /// Waits until the publisher of another node is known.
  void know_publisher();

 private:
  Node node_ = Node::open({.name = "member", .transport = TransportChoice::udp}).value();
  std::optional<DynamicType> type_;
};

class CycloneMember {
 public:
  static constexpr const char* name = "Cyclone DDS";

  class Writer {
   public:
    Writer(CycloneMember& member, const Payload& payload);
    bool serves(std::size_t readers) const { return CycloneParticipant::readers(writer_) == readers; }
    void write() { dds_write(writer_, message_.get()); }

   private:
    const dds_entity_t writer_;
    const std::shared_ptr<void> message_;
  };

  /// Reads clouds.
  class Reader {
   public:
    explicit Reader(CycloneMember& member);
    bool matched() const { return CycloneParticipant::writers(reader_) == 1; }

   private:
    const dds_entity_t reader_;
  };

  /// Gets all fields, whatever it asks for.
  class MaskedReader {
   public:
    MaskedReader(CycloneMember& member, const Payload& payload, std::function<void()> arrived);
    ~MaskedReader() { dds_delete(reader_); }  // ends its callbacks before the members are destroyed
    MaskedReader(const MaskedReader&) = delete;
    MaskedReader& operator=(const MaskedReader&) = delete;
    void ask_for(const std::string&) {}
    bool matched() const { return CycloneParticipant::writers(reader_) == 1; }

   private:
    static void take_all(dds_entity_t reader, void* self);

    const std::function<void()> arrived_;
    std::vector<std::uint64_t> message_;  ///< into which every sample is taken, so that nothing is allocated
    const dds_entity_t reader_;
  };

  void know_publisher();

 private:
  const CycloneParticipant participant_{""};
};

}  // namespace sft::bench
