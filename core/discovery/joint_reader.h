// The reader of a control topic, which the nodes of a process share as long as they use the same Cyclone
// domain: what others say comes to a process once, however many nodes it has. Each reader would catch up by
// itself otherwise, and be told of everything again. Any thread.
#pragma once

#include <dds/dds.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/discovery/control_qos.h"
#include "core/discovery/control_words.h"
#include "core/discovery/kept_words.h"
#include "core/discovery/matches.h"
#include "core/discovery/remote_writers.h"
#include "core/discovery/topic_endpoint.h"
#include "core/sync/guarded_call.h"
#include "core/sync/mutex.h"
#include "sft/result.h"

namespace sft::core {

/// A node's link, as those see it who bring what others say.
class Hearer {
 public:
  /// `hear` is called on any thread, but by one reader for one word at a time.
  Hearer(dds_entity_t participant, std::function<void(const ControlWord&)> hear)
      : participant_(participant), hear_(std::move(hear)) {}

  dds_entity_t participant() const { return participant_; }
  void hear(const ControlWord& word) {
    gate_.call([&] { hear_(word); });
  }
  /// When it returns, `hear` does not run any more.
  void close() { gate_.close(); }

 private:
  const dds_entity_t participant_;
  const std::function<void(const ControlWord&)> hear_;
  CallGate gate_;
};

class JointReader {
 public:
  struct Kind {
    TopicName topic;
    ControlWords (*take)(dds_entity_t reader, RemoteWriters& writers) = nullptr;
  };
  /// `qos`: of the topic.
  JointReader(const Kind& kind, const dds_qos_t* qos) : kind_(kind), qos_(copy_of(qos)) {}
  JointReader(const JointReader&) = delete;
  JointReader& operator=(const JointReader&) = delete;

  /// From now on the hearer hears everything, also what is in force of what others have said before. The
  /// first hearer's participant has the reader. A second call does nothing unless nobody has the reader.
  /// False if the hearer could not be told everything: it needs another reader.
  Result<bool> join(const std::shared_ptr<Hearer>& hearer);
  /// To be called before the participant of the hearer is deleted. If it has the reader, the participant of
  /// another hearer gets a new one.
  void leave(const std::shared_ptr<Hearer>& hearer);
  /// The participant is not there any more.
  void forget(const Participants::Guid& participant);
  /// False if join() would be in vain for another hearer.
  bool takes_newcomers() {
    const Lock lock(mutex_);
    return kept_.are_complete();
  }

 private:
  using Hearers = std::vector<std::shared_ptr<Hearer>>;
  using Words = std::vector<KeptWords::Word>;

  Result<void> host(const std::shared_ptr<Hearer>& hearer) SFT_REQUIRES(joining_);
  std::shared_ptr<const Hearers> hearers_without(const std::shared_ptr<Hearer>& hearer);
  /// Takes all that the reader has, and tells it.
  void hear(dds_entity_t reader);
  Words kept(ControlWords words) SFT_REQUIRES(mutex_);
  static void tell(const Words& words, const Hearers& hearers);
  static void on_data(dds_entity_t reader, void* self);
  static void on_matched(dds_entity_t reader, dds_subscription_matched_status_t status, void* self);

  const Kind kind_;
  const DdsQos qos_;

  /// Held while readers are made and deleted, which waits for listeners: these do not take it.
  Mutex joining_ SFT_ACQUIRED_BEFORE(telling_);
  std::shared_ptr<Hearer> host_ SFT_GUARDED_BY(joining_);  ///< whose participant has the reader
  dds_entity_t reader_ SFT_GUARDED_BY(joining_) = 0;

  /// Held while words are taken and told, so that they are told in their order, and are not taken faster than
  /// they are told. Hearers note what they hear; they neither wait for anything nor speak.
  Mutex telling_ SFT_ACQUIRED_BEFORE(mutex_);

  Mutex mutex_;
  std::shared_ptr<const Hearers> hearers_ SFT_GUARDED_BY(mutex_) = std::make_shared<const Hearers>();
  RemoteWriters writers_ SFT_GUARDED_BY(mutex_);
  Matches matches_ SFT_GUARDED_BY(mutex_);
  KeptWords kept_ SFT_GUARDED_BY(mutex_);
};

/// The readers that the nodes of a process share in one Cyclone domain. Any thread.
class JointReaders {
 public:
  /// The reader of that topic, one that takes newcomers. `qos`: of the topic, if there is no such reader yet.
  std::shared_ptr<JointReader> of(const JointReader::Kind& kind, const dds_qos_t* qos);
  /// The participant is not there any more.
  void forget(const Participants::Guid& participant);

 private:
  Mutex mutex_;
  std::map<std::string, std::shared_ptr<JointReader>> readers_ SFT_GUARDED_BY(mutex_);
  /// Those that take no newcomers, and go with their last hearer.
  std::vector<std::weak_ptr<JointReader>> former_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
