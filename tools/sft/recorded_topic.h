// One topic with one type, as `sft record` receives it.
//
// Publishers of a topic may offer different QoS. Each kind of offer has a subscriber that requests just that,
// so that retained samples come and reliable ones are not lost; of a sample that several subscribers get, one
// is taken. Each publisher's node and offer has a channel of its own in the file.
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
    std::uint64_t lost_by_queue = 0;  ///< our own subscribers' queues
    std::uint64_t lost_by_disk = 0;
    std::uint64_t lost() const { return lost_by_network + lost_by_queue + lost_by_disk; }
  };

  /// `text` is what the user selects. The error says what is wrong with the selection, or, if it is
  /// Errc::unavailable, why such a type cannot be recorded.
  static Result<RecordedTopic> open(std::string topic, const DynamicType& type, const std::string& text);

  const std::string& topic() const { return topic_; }
  const DynamicType& type() const { return type_; }
  Counts counts() const;
  /// Looks at what was lost until now, for counts(). The status of a subscriber forgets departed publishers.
  void look_at_losses(const SampleWriter& writer);

  /// Subscribes for a publisher of this topic and type, unless that has been done. `epoll` gets the file
  /// descriptors of new subscribers, with this object as their data: it must not move any more.
  Result<void> follow(const DomainSnapshot::Endpoint& publisher, Node& node, int epoll, SampleWriter& writer);
  /// Passes on all samples that have come. `now_ns` is the time that they are recorded with; nothing: the
  /// system's time at which each came.
  void take(SampleWriter& writer, std::optional<std::uint64_t> now_ns);
  /// Discards what has come so far, except retained samples.
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
    bool is_guess = false;  ///< a sample came before the publisher was seen
    /// The numbers of the last samples that were taken while it was a guess. They may come again.
    std::deque<std::uint64_t> taken{};
  };
  struct Loss {
    std::uint64_t before = 0;  ///< before samples that were taken
    std::uint64_t known = 0;   ///< by the status of the subscriber, with those behind the last sample
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
  std::map<std::uint64_t, Source> sources_{};      ///< by the id of the publisher
  std::map<std::string, std::size_t> channels_{};  ///< by node and offer
  std::map<std::uint64_t, Loss> losses_{};         ///< by the id of the publisher
  std::uint64_t unwritten_ = 0;                    ///< samples of counts_ that are in no file
  Counts counts_{};
};

}  // namespace sft::tool
