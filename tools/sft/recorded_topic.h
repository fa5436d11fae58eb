// One topic with one type, as `sft record` receives it.
//
// Publishers of a topic may offer different QoS. There is one subscriber for each combination of
// reliability and durability, which requests exactly these. So retained samples are received, and samples
// of reliable publishers are not lost. If several subscribers receive a sample, only one of them takes it.
// In the file, each node has its own channel for each of these combinations.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "tools/sft/sample_writer.h"
#include "tools/sft/session.h"

namespace sft::tool {

class RecordedTopic {
 public:
  struct Counts {
    std::uint64_t samples = 0;
    std::uint64_t bytes = 0;
    std::uint64_t lost_by_network = 0;
    std::uint64_t lost_by_queue = 0;  ///< samples that had no space in the queues of our subscribers
    std::uint64_t lost_by_disk = 0;
    std::uint64_t lost() const { return lost_by_network + lost_by_queue + lost_by_disk; }
  };

  /// `text` is the selection of the user. The error says what is wrong with the selection.
  /// Errc::unavailable means instead that the type cannot be recorded, and the error says why.
  static Result<RecordedTopic> open(std::string topic, const DynamicType& type, const std::string& text);

  const std::string& topic() const { return topic_; }
  const DynamicType& type() const { return type_; }
  Counts counts() const;
  /// Updates the losses for counts(). Must be called regularly, since the status of a subscriber does not
  /// contain publishers that have left.
  void look_at_losses(const SampleWriter& writer);

  /// Subscribes for a publisher of this topic and type, unless a subscriber for its QoS exists. The file
  /// descriptors of new subscribers are added to `epoll`, with the address of this object as their data. So
  /// the object must not be moved any more.
  Result<void> follow(const DomainSnapshot::Endpoint& publisher, Node& node, int epoll, SampleWriter& writer);
  /// Passes all samples that have arrived to the writer. `now_ns` is the time with which they are recorded.
  /// Without it, each sample is recorded with the system time of its arrival.
  void take(SampleWriter& writer, std::optional<std::uint64_t> now_ns);
  /// Discards the samples that have arrived so far, except retained samples.
  void discard();

 private:
  struct Offer {
    Reliability reliability;
    Durability durability;
    friend bool operator==(const Offer&, const Offer&) = default;
  };
  struct Subscription {
    Offer offer;
    DynamicSubscriber subscriber;
    std::uint64_t discarded = 0;
  };
  struct Source {
    std::size_t channel;
    Offer offer;
    /// True: a sample arrived before the publisher was discovered, and `offer` is that of the subscriber
    /// that received it
    bool is_guess = false;
    /// The numbers of the last samples that were taken while `is_guess` was true. Another subscriber may
    /// receive these samples again.
    std::deque<std::uint64_t> taken{};
  };
  struct Loss {
    std::uint64_t before = 0;  ///< losses that were detected by later samples
    /// losses in the status of the subscriber, which include losses after the last sample that was taken
    std::uint64_t known = 0;
    bool by_queue = false;
  };

  RecordedTopic(std::string topic, const DynamicType& type, std::string text, Selection selection,
                recording::Schema schema)
      : topic_(std::move(topic)),
        type_(type),
        text_(std::move(text)),
        selection_(std::move(selection)),
        schema_(std::move(schema)) {}
  std::size_t channel_of(const DomainSnapshot::Endpoint& publisher, SampleWriter& writer);
  static bool is_known(Source& source, std::uint64_t sequence);
  void take(Subscription& from, SampleWriter& writer, std::optional<std::uint64_t> now_ns);

  std::string topic_;
  DynamicType type_;
  std::string text_;
  Selection selection_;
  recording::Schema schema_;
  std::deque<Subscription> subscribers_{};
  std::map<std::uint64_t, Source> sources_{};      ///< publishers by their ids
  std::map<std::string, std::size_t> channels_{};  ///< numbers of channels, by node and offer
  std::map<std::uint64_t, Loss> losses_{};         ///< losses by the id of the publisher
  /// the number of samples in counts_ that are in no file, because writing failed
  std::uint64_t unwritten_ = 0;
  Counts counts_{};
};

}  // namespace sft::tool
