#include "tests/hostile/stage.h"

#include <poll.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "shm_transport/sftd/exit_code.h"
#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"

namespace sft::hostile {

using namespace std::chrono_literals;
using test::json;

namespace {

constexpr uid_t honest_user = 1;  // "daemon" in every /etc/group; sftd needs a group with a name
constexpr uid_t other_user = 65534;
constexpr const char* programs = "/srv";  // for accounts that must not enter the checkout
constexpr std::chrono::microseconds publishing_period = 5ms;
constexpr Ms hang_timeout = test::hang_timeout;
constexpr Ms timeout_while_setting_up = 2s;

/// Returns the account, and mounts the programs at a path that it can read. The simulated hosts copy this
/// process's mount namespace.
test::Account account(uid_t user) {
  if (access((std::string(programs) + "/sftd").c_str(), X_OK) != 0 &&
      mount(test::program_directory().c_str(), programs, nullptr, MS_BIND, nullptr) != 0)
    throw std::system_error(errno, std::generic_category(), programs);
  return {user, programs};
}

/// The directory is not in /tmp or /dev/shm, because each host has separate ones.
constexpr const char* certificates_directory = "/media/certificates";

/// Makes the certificate of the honest programs if the programs should have one and it does not exist yet.
/// Returns its argument.
Certificates made(Certificates certificates) {
  if (certificates == Certificates::none || access(certificates_directory, X_OK) == 0) return certificates;
  if (mount("tmpfs", "/media", "tmpfs", 0, "size=4m") != 0)
    throw std::system_error(errno, std::generic_category(), "/media");
  const std::string directory = certificates_directory;
  const std::string command = std::string(programs) + "/make_certificates.sh " + directory +
                              " honest && chown -R " + std::to_string(honest_user) + " " + directory;
  if (std::system(command.c_str()) != 0) throw std::runtime_error("no certificates: " + command);
  return certificates;
}

json honest_policies(bool is_reliable) { return {{"reliable", is_reliable}}; }

/// Returns a short description of one end of a pair.
std::string describe(const json& entry) {
  if (entry.is_null()) return "knows nothing of it";
  const bool is_up = entry.value("served", entry.value("matched", false) && entry.value("alive", false));
  return (is_up ? "served by " + entry["transport"].get<std::string>() : std::string("not served")) + " (" +
         entry["reason"].get<std::string>() + ")";
}
std::string describe(const std::string& name, const json& reader, const json& seen) {
  std::string text = "'" + name + "': the publisher: " + describe(reader) +
                     "; the subscriber: " + describe(seen["writer"]) +
                     ", shared memory: " + seen["shm"].get<std::string>();
  if (seen.contains("taken")) text += ", taken: " + seen["taken"].dump();
  return text;
}

bool names_a_file(const std::string& status) {
  return status.find("/tmp/") != std::string::npos || status.find("/dev/shm/") != std::string::npos;
}

bool is_stopped(pid_t process) {
  std::string stat;
  std::getline(std::ifstream("/proc/" + std::to_string(process) + "/stat"), stat);
  return stat.find(") T ") != std::string::npos;
}

bool runs_as_root_of_many_accounts() {
  unsigned first = 0, outside = 0;
  unsigned long count = 0;
  std::string line;
  std::getline(std::ifstream("/proc/self/uid_map"), line);
  return geteuid() == 0 && std::sscanf(line.c_str(), "%u %u %lu", &first, &outside, &count) == 3 &&
         count > other_user;
}

}  // namespace

std::string_view to_string(Moment moment) {
  switch (moment) {
    case Moment::before_they_start:
      return "before they start";
    case Moment::while_they_start:
      return "while they start";
    case Moment::after_they_started:
      return "after they started";
  }
  return "";
}

/// A subscriber, and counts of the samples that it gets from the publisher.
struct Stage::Pair {
  std::string name;
  const test::Host& host;
  std::string transport;  ///< the transport that serves the subscriber in the normal case
  bool is_reliable;
  std::unique_ptr<test::Peer> subscriber{};
  std::uint64_t received = 0;     ///< the number of samples received by any path, at the last look()
  std::uint64_t received_by = 0;  ///< the number of samples received by `transport`, at the last look()
  std::string state{};
  bool falls_back = false;  ///< served by UDP instead of shared memory, and the status names an obstructing
                            ///< file
  bool is_stopped = false;  ///< the present act has stopped the subscriber

  /// The numbers of samples at one moment, with which later numbers are compared.
  struct Noted {
    std::uint64_t received, received_by;
  };
  Noted note() const { return {received, received_by}; }
};

/// A process of hostile_actor that performs an act.
class Stage::Actor {
 public:
  Actor(const Stage& stage, const Entry& entry) : name_(entry.name) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
      throw std::system_error(errno, std::generic_category(), "socketpair");
    socket_ = ends[0];
    const test::Host& host = entry.attacker == Attacker::neighbour ? stage.elsewhere_ : stage.here_;
    const uid_t user = entry.attacker == Attacker::other_account ? other_user
                       : entry.attacker == Attacker::owner       ? honest_user
                                                                 : 0;
    process_.emplace(
        host, "hostile_actor",
        std::vector<std::string>{name_, std::to_string(honest_user), std::to_string(stage.seed_)}, ends[1],
        account(user));
    close(ends[1]);
  }
  /// Ends the act if end() was not called, so that no honest program stays stopped.
  ~Actor() {
    if (!has_ended_) {
      (void)!send(socket_, "end", 3, MSG_NOSIGNAL);
      hear();
    }
    close(socket_);
  }
  Actor(const Actor&) = delete;
  Actor& operator=(const Actor&) = delete;

  void await_begin() {
    if (hear() != "begun") throw std::runtime_error("act " + name_ + " does not begin");
  }
  /// Ends the act, and returns what the attacker has gained.
  std::string end() {
    has_ended_ = true;
    (void)!send(socket_, "end", 3, MSG_NOSIGNAL);
    const std::string last_words = hear();
    if (!last_words.starts_with("ended")) throw std::runtime_error("act " + name_ + " does not end");
    process_->wait_for_end();
    return last_words.size() > 7 ? last_words.substr(7) : "";
  }

 private:
  std::string hear() {
    pollfd readable{.fd = socket_, .events = POLLIN, .revents = 0};
    char text[1000];
    if (poll(&readable, 1, static_cast<int>(hang_timeout.count())) <= 0) return {};
    const ssize_t bytes = recv(socket_, text, sizeof text, 0);
    return {text, static_cast<std::size_t>(std::max<ssize_t>(bytes, 0))};
  }

  std::string name_;
  int socket_ = -1;
  bool has_ended_ = false;
  std::optional<test::Process> process_;
};

std::string Stage::refusal() {
  if (!test::isolation_refusal().empty()) return test::isolation_refusal();
  if (!runs_as_root_of_many_accounts()) return "needs root, to start programs of other accounts";
  return test::Network::refusal();
}

Stage::Stage(std::uint64_t seed, Certificates certificates)
    : seed_(seed),
      honest_(account(honest_user)),
      certificates_(made(certificates)),
      network_(seed),
      here_(network_),
      there_(network_),
      elsewhere_(network_) {
  const auto pair = [this](const char* name, const test::Host& host, const char* transport,
                           bool is_reliable) {
    pairs_.push_back(std::make_unique<Pair>(Pair{name, host, transport, is_reliable}));
  };
  pair("near", here_, "shm", false);
  pair("far", there_, "udp", false);
  pair("far_and_reliable", there_, "udp", true);
}

Stage::~Stage() = default;

json Stage::options(bool start_daemon) const {
  json options{{"start_daemon", start_daemon}};
  if (certificates_ == Certificates::all)
    options["cyclonedds"] = std::string("file://") + certificates_directory + "/honest/cyclonedds.xml";
  return options;
}

/// Returns the harm to expect. Messages in the names of other participants harm only programs without
/// certificates.
Harm Stage::harm_of(const Entry& entry) const {
  return entry.harm == Harm::forges && certificates_ == Certificates::all ? Harm::none : entry.harm;
}

void Stage::launch() {
  if (!publisher_) {
    // Each publisher has a new name, so that it is not mistaken for an earlier publisher that was killed.
    const std::string name = "publisher_" + std::to_string(++publishers_);
    publisher_ = std::make_unique<test::Peer>(here_, name, options(true), honest_);
    publisher_->advertise(honest_policies(true));
    publisher_->start_publishing(publishing_period);
  }
  for (const auto& pair : pairs_) {
    if (pair->subscriber) continue;
    pair->subscriber =
        std::make_unique<test::Peer>(pair->host, pair->name, options(pair->transport == "shm"), honest_);
    pair->subscriber->subscribe("height, width", honest_policies(pair->is_reliable));
    pair->received = pair->received_by = 0;
  }
}

/// Asks both sides, and returns true if both report that the pair is served by its usual transport. A
/// subscriber that the act has stopped is not asked, because it cannot answer. Such a subscriber counts as
/// served until the act ends.
bool Stage::look(Pair& pair) {
  if (pair.is_stopped) return true;
  const json reader = publisher_->look_at(pair.name)["reader"];
  const json seen = pair.subscriber->look_at(publisher_->name());
  const json& writer = seen["writer"];
  pair.state = describe(pair.name, reader, seen);
  if (seen.contains("taken")) {
    const std::uint64_t by_shm = seen["taken"]["by_shm"];
    pair.received = seen["taken"]["received"];
    pair.received_by = pair.transport == "shm" ? by_shm : pair.received - by_shm;
  }
  const bool is_served =
      !reader.is_null() && !writer.is_null() && reader["served"] && writer["matched"] && writer["alive"];
  const auto by = [&](const std::string& transport) {
    return is_served && reader["transport"] == transport && writer["transport"] == transport;
  };
  pair.falls_back = by("udp") && names_a_file(seen["shm"]);
  return by(pair.transport);
}

bool Stage::all_served(Harm harm) {
  bool all = true;
  for (const auto& pair : pairs_)
    all = (look(*pair) || (harm == Harm::leaves_files && pair->falls_back)) && all;
  return all;
}

std::string Stage::state() {
  std::string text;
  for (const auto& pair : pairs_) text += "\n  " + pair->state;
  return text;
}

bool Stage::start() {
  launch();
  return test::eventually(
      [&] {
        return all_served() && std::ranges::all_of(pairs_, [](const auto& p) { return p->received_by > 2; });
      },
      hang_timeout, 10ms);
}

/// Waits until the act has actually stopped the subscriber, because a signal takes effect with a delay.
void Stage::note_stopped(const Entry& entry, Outcome& outcome) {
  if (entry.harm != Harm::stops_near) return;
  for (const auto& pair : pairs_) {
    if (pair->transport != "shm") continue;
    pair->is_stopped = test::eventually([&] { return is_stopped(pair->subscriber->pid()); }, hang_timeout);
    if (!pair->is_stopped) outcome.complaints.push_back("The act does not stop '" + pair->name + "'");
  }
}

/// Expects that samples arrive at every subscriber by any path. A pair that is being set up is given time
/// for this.
void Stage::expect_samples(Outcome& outcome) {
  std::vector<Pair::Noted> noted;
  all_served();
  for (const auto& pair : pairs_) noted.push_back(pair->note());
  const auto comes = [&](std::size_t i) {
    return pairs_[i]->is_stopped || (look(*pairs_[i]), pairs_[i]->received > noted[i].received + 2);
  };
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (!test::eventually([&] { return comes(i); }, hang_timeout, 10ms))
      outcome.complaints.push_back("While the act lasts nothing comes: " + pairs_[i]->state);
  }
}

/// Waits until all pairs are served as before and samples arrive. More than two further samples have to
/// arrive, because some may have been under way when the act ended.
void Stage::await_recovery(const Entry& entry, Clock::time_point ended, Outcome& outcome) {
  std::vector<Pair::Noted> noted;
  all_served();
  for (const auto& pair : pairs_) noted.push_back(pair->note());
  const auto recovered = [&] {
    bool all = all_served(entry.harm);
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      all = all && (pairs_[i]->received_by > noted[i].received_by + 2 ||
                    (entry.harm == Harm::leaves_files && pairs_[i]->received > noted[i].received + 2));
    }
    return all;
  };
  if (test::eventually(recovered, hang_timeout, 5ms)) {
    outcome.recovery = std::chrono::duration_cast<Ms>(Clock::now() - ended);
  } else {
    outcome.complaints.push_back("After the act not all are served again:" + state());
  }
}

/// Waits until `sftd status` answers while all pairs are served. The pairs may have continued in the memory
/// of a daemon that is about to be replaced. In this case no daemon may be running for a moment, or the new
/// daemon may not answer yet. Any other failure is added to the complaints.
void Stage::await_command_line(const Entry& entry, Clock::time_point ended, Outcome& outcome) {
  auto code = shm::ExitCode::not_running;
  const auto is_over = [&] {
    test::Process status(here_, "hostile_actor", {"--sftd-status"}, -1, honest_);
    code = static_cast<shm::ExitCode>(status.wait_for_end());
    if (code == shm::ExitCode::not_running || code == shm::ExitCode::no_answer) return false;
    return code != shm::ExitCode::done || all_served(entry.harm);
  };
  if (test::eventually(is_over, hang_timeout, 5ms) && code == shm::ExitCode::done) {
    outcome.command_line = std::chrono::duration_cast<Ms>(Clock::now() - ended);
  } else {
    outcome.complaints.push_back("After the act `sftd status` ends with " +
                                 std::to_string(static_cast<int>(code)) + state());
  }
}

Outcome Stage::perform(const Entry& entry, Moment moment, Ms length) {
  Outcome outcome;
  for (const auto& pair : pairs_) pair->is_stopped = false;
  try {
    if (moment == Moment::after_they_started && !start()) {
      outcome.complaints.push_back("Before the act not all are served:" + state());
      return outcome;
    }
    // A stopped program answers no command, so it must have subscribed before.
    if (entry.harm == Harm::stops_near) launch();
    Actor actor(*this, entry);
    if (moment == Moment::while_they_start) launch();
    actor.await_begin();
    note_stopped(entry, outcome);
    launch();
    const auto begin = Clock::now();
    // Pairs that can be set up even during the act are awaited here, so that this time does not count as
    // recovery from the act.
    if (moment != Moment::after_they_started)
      test::eventually([&] { return all_served(); }, timeout_while_setting_up, 20ms);
    const Harm harm = harm_of(entry);
    const bool spares_samples = harm != Harm::floods && harm != Harm::forges;
    if (spares_samples) expect_samples(outcome);
    const auto left = std::chrono::duration_cast<Ms>(begin + length - Clock::now());
    poll(nullptr, 0, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
    if (spares_samples) expect_samples(outcome);
    if (const std::string loot = actor.end(); !loot.empty()) outcome.complaints.push_back(loot);
    for (const auto& pair : pairs_) pair->is_stopped = false;
    const auto ended = Clock::now();
    await_recovery(entry, ended, outcome);
    if (entry.harm != Harm::leaves_files) await_command_line(entry, ended, outcome);
  } catch (const std::exception& error) {
    outcome.complaints.push_back(error.what());
  }
  return outcome;
}

std::optional<Ms> Stage::restart_publisher() {
  publisher_->kill_now();
  publisher_.reset();
  for (const auto& pair : pairs_) pair->received_by = 0;
  const auto begin = Clock::now();
  if (!start()) return std::nullopt;
  return std::chrono::duration_cast<Ms>(Clock::now() - begin);
}

std::vector<std::string> Stage::end() {
  std::vector<std::string> complaints;
  const auto quit = [&](std::unique_ptr<test::Peer>& peer) {
    if (!peer) return;
    if (const int code = peer->quit(); code != 0)
      complaints.push_back("'" + peer->name() + "' ends with " + std::to_string(code));
    peer.reset();
  };
  for (const auto& pair : pairs_) quit(pair->subscriber);
  quit(publisher_);
  return complaints;
}

}  // namespace sft::hostile
