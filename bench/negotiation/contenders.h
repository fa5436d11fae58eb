// A program with SFT and one with Cyclone DDS alone. Both have the same interface, so that each group
// measures both.
#pragma once

#include <sft/sft.h>
#include <atomic>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>

#include "bench/common/node_options.h"
#include "bench/negotiation/raw_cyclone.h"

namespace sft::bench {

/// The samples that a late reader gets: those that are sent from then on, or the last one before as well.
enum class Late { nothing, last_sample };

class SftProgram {
  using Message = sensor_msgs::msg::PointCloud2;
  using F = Message::Field;

 public:
  class Writer {
   public:
    Writer(SftProgram& program, const std::string& topic, Late late)
        : publisher_(program.node_.publisher<Message>(topic, {.durability = durability(late)}).value()) {}
    void send() { publisher_.publish(message_); }
    std::size_t readers() const { return publisher_.status().readers.size(); }

   private:
    Publisher<Message> publisher_;
    const Message message_;
  };

  class Reader {
   public:
    Reader(SftProgram& program, const std::string& topic, Late late)
        : subscriber_(
              program.node_.subscriber<Message, F::height | F::width>(topic, {.durability = durability(late)})
                  .value()) {}
    /// Waits until a sample has come. False after five seconds.
    bool wait() { return subscriber_.wait(std::chrono::seconds(5)); }

   private:
    Subscriber<Message, F::height | F::width> subscriber_;
  };

 private:
  static Durability durability(Late late) {
    return late == Late::nothing ? Durability::volatile_ : Durability::transient_local;
  }

  Node node_ = Node::open(udp_node_options("bench")).value();
};

class RawProgram {
 public:
  class Writer {
   public:
    Writer(RawProgram& program, const std::string& topic, Late late)
        : writer_(program.cyclone_.writer(topic, delivery(late))) {}
    void send() { RawCyclone::write(writer_, ++number_); }
    std::size_t readers() const { return RawCyclone::readers(writer_); }

   private:
    const dds_entity_t writer_;
    std::uint64_t number_ = 0;
  };

  class Reader {
   public:
    Reader(RawProgram& program, const std::string& topic, Late late)
        : reader_(program.cyclone_.reader(topic, delivery(late), arrived_)) {}
    ~Reader() { dds_delete(reader_); }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    bool wait() {
      came_.wait(false);
      return true;
    }

   private:
    std::atomic<bool> came_{false};
    const RawCyclone::Arrived arrived_ = [this](std::uint64_t) {
      came_ = true;
      came_.notify_one();
    };
    const dds_entity_t reader_;
  };

 private:
  static RawCyclone::Delivery delivery(Late late) {
    return late == Late::nothing ? RawCyclone::Delivery::best_effort : RawCyclone::Delivery::last_value;
  }

  RawCyclone cyclone_;
};

}  // namespace sft::bench
