// Processes that exchange records and heartbeats on several networks, in one thread and in simulated time.
// Networks lose, delay and reorder datagrams, and may be cut. Attackers stall links, and write in the names
// of other processes. All random numbers come from one seed.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/discovery/own_records.h"
#include "core/discovery/peers.h"

namespace sft::core::test {

using namespace std::chrono_literals;

struct SimProcess;

/// A participant of a process. It is on one network.
struct SimLink {
  SimProcess* process = nullptr;
  int network = 0;
  LinkId id = 0;
  ParticipantGuid guid{};
  bool is_open = true;
  /// The heartbeats since the agent's last turn, with their times of arrival.
  std::vector<std::pair<Heartbeat, Time>> unread{};
};

/// The records of other processes, as collected only from the actions that Peers returns.
using Mirror = std::map<ProcessId, PerRole<std::map<RecordKey, Record>>>;

struct SimProcess {
  SimProcess(ProcessId process, const Timing& timing)
      : id(process), own(process, timing), peers(process, timing) {}
  const ProcessId id;
  OwnRecords own;
  Peers peers;
  Mirror mirror{};
  std::vector<SimLink*> links{};
  std::map<LinkId, int> renewals_due{};
  Time looked_at{};
  bool is_killed = false;
  std::uint64_t owners = 0;  ///< the number of endpoints opened so far
  std::vector<std::pair<Role, std::uint64_t>> open{};
};

/// Larger than usual: the class has a function for each kind of event on the simulated networks.
class ControlWorld {
 public:
  explicit ControlWorld(std::uint64_t seed) : random_(seed) {}

  // Functions that make an event happen.

  SimProcess& start(int networks);
  /// Opens, closes or changes a random endpoint of the process.
  void change(SimProcess& process);
  void kill(SimProcess& process);
  void lose(double share) { loss_ = share; }
  void cut(int network, bool is_cut);
  bool is_cut(int network) const { return cuts_.contains(network); }
  /// Forges a random item in the name of a participant that another process knows.
  void attack();
  /// Adds a foreign participant with records of its own. For the time `lasts` the participant claims to
  /// belong to `process`.
  void claim(const SimProcess& process, Time::duration lasts);
  void run(Time::duration time);

  // Functions that return the state.

  Time now() const { return now_; }
  const std::vector<std::unique_ptr<SimProcess>>& processes() const { return processes_; }
  int renewals() const { return renewals_; }
  /// Returns the first error, or "" if each process has the records of all others, and no records of killed
  /// processes.
  std::string what_is_wrong() const;
  /// Returns the number of records that were replaced by older ones. For runs without attacks.
  int steps_back() const { return steps_back_; }

  std::size_t below(std::size_t end) { return static_cast<std::size_t>(random_() % end); }
  bool chance(double share) { return std::uniform_real_distribution<>(0, 1)(random_) < share; }
  Time::duration up_to(Time::duration most) {
    return Time::duration(static_cast<Time::rep>(random_() % static_cast<std::uint64_t>(most.count())) + 1);
  }

 private:
  /// The state that Cyclone keeps in one participant about another one.
  struct Channel {
    bool is_found = false;
    bool is_stalled = false;  ///< whether records are dropped as outdated
    Time heard_at{};          ///< the time of the last arrival
    unsigned number = 0;      ///< the number of times that the participant was found
    /// Records under way, in the order of writing, with their times of arrival.
    std::deque<std::pair<Time, std::function<void()>>> written{};
  };
  struct Event {
    Time at{};
    std::uint64_t number = 0;
    std::function<void()> act;
    bool operator<(const Event& other) const {
      return std::pair(at, number) > std::pair(other.at, other.number);
    }
  };
  using Pair = std::pair<LinkId, LinkId>;  ///< the link of the hearer, and the link of the writer

  void at(Time time, std::function<void()> act) { events_.push({time, events_made_++, std::move(act)}); }
  void open(SimProcess& process, int network, std::optional<LinkId> instead_of);
  void close(SimLink& link, bool says_so);
  void announce(SimLink& link, bool asks);
  void hear_announcement(SimLink& hearer, SimLink& of, bool asks, bool is_answer);
  void find(SimLink& hearer, SimLink& writer);
  void forget(SimLink& hearer, SimLink& writer);
  void write_to_all(SimProcess& process, Role role, const OwnRecords::Change& change);
  void write(SimLink& hearer, SimLink& writer, Role role, const RecordKey& key, const Record& record);
  void deliver(SimLink& hearer, SimLink& writer, unsigned number);
  void give_heartbeat(SimLink& link);
  void look(SimProcess& process);
  void act(SimProcess& process);
  void note(SimProcess& process, const PeerAction& action);
  SimLink* link_of(SimProcess& process, LinkId id);
  bool reaches(const SimLink& from, const SimLink& to) const {
    return from.is_open && to.is_open && from.network == to.network && from.process != to.process &&
           !is_cut(from.network);
  }
  template <class Use>
  void each_hearer(const SimLink& of, Use use) {
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (links_[i]->is_open && links_[i]->network == of.network && links_[i]->process != of.process)
        use(*links_[i]);
    }
  }
  Channel& channel(const SimLink& hearer, const SimLink& writer) { return channels_[{hearer.id, writer.id}]; }
  std::vector<std::byte> random_body();

  const Timing timing_{};
  std::mt19937_64 random_;
  Time now_ = Time(100s);
  double loss_ = 0;
  std::map<int, bool> cuts_;
  std::vector<std::unique_ptr<SimProcess>> processes_;
  std::vector<std::unique_ptr<SimLink>> links_;
  std::map<Pair, Channel> channels_;
  std::priority_queue<Event> events_;
  std::uint64_t events_made_ = 0;
  int renewals_ = 0;
  int steps_back_ = 0;
};

}  // namespace sft::core::test
