// How nodes, publishers and subscribers are set up: plain structs, read once.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sft/event.h"
#include "sft/qos.h"

namespace sft {

/// Which way samples may travel. `automatic` is shared memory between processes of one host and UDP between
/// hosts, and UDP within a host while shared memory is not to be had.
enum class TransportChoice : std::uint8_t { automatic, shm, udp };

/// debug: what subscribers ask for, whenever that changes; info: what happens to pairs, by which path and
/// why; warning: what fails, or will never work as it is set up; error: what is over until the node is opened
/// again.
enum class LogLevel : std::uint8_t { debug, info, warning, error };
/// Called on the node's agent thread, as event callbacks are: be short, no lock is held, everything of SFT
/// may be called. Others take a node whose sink blocks for 5 s (14 s with peers or without multicast) for
/// dead, and do not serve it until it goes on. One sink for several nodes is called by a thread of each. Of
/// what comes again and again, ten lines of a kind are written and then one in 5 s, which says how many were
/// left out.
using LogSink = std::function<void(LogLevel, std::string_view)>;

/// Whether samples may be sent once for several hosts. `automatic`: where that puts fewer bytes on the wire,
/// and not on wireless interfaces (udp_transport/multicast/multicast.md). A switch without IGMP snooping
/// passes it on to all hosts, which their cables have to bear: there, off.
enum class MulticastUse : std::uint8_t { automatic, off };

/// UDP: port, buffers, limits.
struct UdpSettings {
  /// 0: any free one, and another for what answers to samples that are sent. One that is chosen has it all.
  std::uint16_t port = 0;
  std::size_t receive_buffer_bytes = 32 * 1024 * 1024;  ///< asked of the kernel, which may grant less
  std::size_t memory_limit_bytes = 256 * 1024 * 1024;   ///< of all samples outside of shared memory
  bool use_io_uring = true;                             ///< false: plain sockets
  /// Of all that the node sends by UDP, headers of SFT included; 0: no limit. Small samples go first. What a
  /// queue cannot hold meanwhile is dropped, the oldest first, and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// Whether readers on several hosts may be sent one copy together.
  MulticastUse multicast = MulticastUse::automatic;
};

/// Shared memory: the daemon sftd, and whose daemon is trusted.
struct ShmSettings {
  bool start_daemon = true;  ///< start sftd when none runs
  /// Of sftd. Empty: what $SFT_DAEMON names; else beside the program, in ../libexec/sft from there, where SFT
  /// is installed, where it was built if it is a part of another project, in PATH.
  std::string daemon_path{};
  std::chrono::seconds daemon_idle_exit{
      0};  ///< a daemon started so ends after so long without clients; 0: never
  /// Whose sftd is used, by name ("robot") or number, besides that of root, of this program's own account,
  /// and of the owner of the directory /run/sft. That account can read all samples in shared memory and end
  /// this program. Another one's daemon is not used: samples go by UDP, and NodeStatus::shm says why. What a
  /// node accepts holds for all nodes of its process.
  std::vector<std::string> daemon_users{};
};

/// How nodes find each other. Nodes of one process may have different settings; those with equal ones, an
/// equal cyclonedds_config and equal NodeThreads::discovery share Cyclone DDS's threads.
struct DiscoverySettings {
  /// Hosts to look for nodes on, besides those that multicast reaches: "10.0.0.7", "robot.local", or with the
  /// port of one process, "10.0.0.7:7410". Both sides have to name each other. On each, the first 20 nodes
  /// are found, or their share of that where hosts have several interfaces.
  std::vector<std::string> peers{};
  /// By name ("eth0"), one of their addresses ("10.0.0.5", "fe80::1%eth0") or their network ("10.0.0.0/24",
  /// "fd00::/64"): nodes are looked for and samples received on these only. Empty: on all that are up, but
  /// for bridges and cables of container engines (docker*, veth*, virbr*, br-* and the like) and interfaces
  /// that cannot multicast. Interfaces that come later or get other addresses are used within 2 s, listed or
  /// not; NodeStatus::discovery names those in use and those that are not there. Nodes of this host find each
  /// other in any case. Those that CYCLONEDDS_URI names go before these.
  std::vector<std::string> interfaces{};
  /// False: nodes on other hosts are found by `peers` only, those on this host in any case.
  bool multicast = true;
};

/// How the system chooses among threads that can run. `normal` is what programs have without asking
/// (SCHED_OTHER). `fifo` and `round_robin` are the real-time policies SCHED_FIFO and SCHED_RR.
enum class SchedulingPolicy : std::uint8_t { normal, fifo, round_robin };

/// What some threads of a node have. They never take over a real-time policy or a CPU set from the thread
/// that opens the node: without settings they have the normal policy, and the CPUs that the program was
/// started with.
struct ThreadSettings {
  /// The numbers of the CPUs that they may run on. Empty: those that the program was started with.
  std::vector<unsigned> cpus{};
  SchedulingPolicy policy = SchedulingPolicy::normal;  ///< real-time policies need a right: see NodeThreads
  /// 1 (lowest) to 99 under a real-time policy, and 0 under the normal one.
  int priority = 0;
  /// What their names in /proc/PID/task/TID/comm begin with: "nav-" makes "sft-udp-recv" "nav-udp-recv". The
  /// system keeps 15 characters of a name. Empty: "sft-", and nothing before the names of Cyclone's threads.
  std::string name_prefix{};
  friend bool operator==(const ThreadSettings&, const ThreadSettings&) = default;
};

/// The threads of a node, by what they do. Node::open() fails if the system refuses what is set here, and
/// says which of these it was: real-time policies need CAP_SYS_NICE or a limit RLIMIT_RTPRIO of at least the
/// priority.
struct NodeThreads {
  /// Receives by UDP, and calls back for what came by UDP while callbacks are short.
  ThreadSettings receiver{};
  /// Sends what publish() left over by UDP, and wakes the readers of this host where several sleep.
  ThreadSettings sender{};
  /// Negotiates, and calls back for events and the log.
  ThreadSettings agent{};
  /// Call back for what came in shared memory, and tell file descriptors.
  ThreadSettings callbacks{};
  /// Those of Cyclone DDS. Nodes of one process with other settings here do not share them. Without effect
  /// where the program itself opened the DDS domain.
  ThreadSettings discovery{};
};

/// How a node finds others, which transports it uses and how, its threads and its log. Read once, by
/// Node::open().
struct NodeOptions {
  /// For people, in UTF-8, at most 255 bytes. Several nodes may have one name.
  std::string name = "node";
  /// DDS domain of the control topics, 0 to 232; default: $ROS_DOMAIN_ID, else 0
  std::optional<std::uint32_t> domain{};
  /// How nodes find each other.
  DiscoverySettings discovery{};
  TransportChoice transport = TransportChoice::automatic;  ///< bound for all endpoints of the node
  /// Of samples over UDP.
  UdpSettings udp{};
  /// Of samples in shared memory.
  ShmSettings shm{};
  /// CPUs, scheduling and names of the threads.
  NodeThreads threads{};
  /// XML or names of files, behind ours, so that it wins; default: $CYCLONEDDS_URI. What SFT cannot do
  /// without wins over it, and is said, in the log and NodeStatus::discovery.
  std::optional<std::string> cyclonedds_config{};
  /// The library itself never prints, nor does Cyclone DDS in a process with a node: its messages, which have
  /// one destination in a process, are kept for the errors that they explain.
  LogSink log{};
  LogLevel log_level = LogLevel::info;  ///< what is below is not even put into words
};

struct PublisherStatus;

/// Durations of 0 mean none: no deadline, never expires, no lease. Deadlines and leases have at least 1 ms.
struct PublisherOptions {
  TransportChoice transport = TransportChoice::automatic;  ///< the paths that samples may go by
  Reliability reliability = Reliability::best_effort;      ///< sft/qos.h says what it means
  Durability durability =
      Durability::volatile_;  ///< transient_local: late subscribers get the last samples, too
  /// Samples kept for late subscribers where durability is transient_local, 1 to 128. They hold their memory,
  /// in shared memory too, and are encoded whole although nobody may ask for all of it.
  std::uint32_t history_depth = 1;
  std::chrono::nanoseconds deadline{0};  ///< promises a sample at least so often; told when it fails
  /// A sample that was published longer ago is not delivered any more, as far as the clocks of both hosts
  /// agree.
  std::chrono::nanoseconds lifespan{0};
  Liveliness liveliness =
      Liveliness::automatic;  ///< who says that the publisher is alive: its node or the program
  std::chrono::nanoseconds liveliness_lease{0};  ///< promises a sign of life at least so often
  /// So long, up to 1 s, publish() may wait for reliable subscribers that do not keep up, on this host and on
  /// others, before it costs them their oldest sample (DDS calls it max_blocking_time). In shared memory it
  /// waits for room in their queues, and for a free chunk where a subscriber rules UDP out; over UDP, for
  /// what it keeps for them to be acknowledged, and at most 10 ms of that also where it runs ahead of the
  /// network by more than 8 MB. A span waits no longer in all than one sample. Best-effort subscribers are
  /// never waited for. None by default: a subscriber that hangs would hold up the program, each time that it
  /// publishes, and with it all other subscribers.
  std::chrono::nanoseconds max_blocking{0};
  /// Of a body. Announced: readers set memory aside for no more. Up to 64 MiB, and 16 MiB without UDP. A
  /// sample that is larger than the largest chunk of shared memory, 16 MiB unless the daemon was set up
  /// otherwise, goes by UDP within the host, like one for which no chunk is free. What is beyond 16 MiB takes
  /// much of UdpSettings::memory_limit_bytes, on both sides.
  std::size_t max_sample_bytes = 16 * 1024 * 1024;
  /// Sent by UDP, over all masks and readers; 0: no limit. Small samples go first, and what a queue cannot
  /// hold meanwhile is dropped, the oldest first, and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// After readers came, left or changed what they ask for, and that is in force: all of them as they are
  /// now. (For what happened to each there is on_event.) On the node's agent thread: be short. Like any
  /// callback it may come before the function that opens the publisher has returned: it must not rely on what
  /// that returns.
  std::function<void(const PublisherStatus&)> on_readers_changed{};
  EventCallback on_event{};  ///< called with what happens to its pairs, on the node's agent thread: be short
};

/// Of subscribers whose fields are recorded. Samples count when they are released.
struct RecordingSettings {
  /// At first all fields are asked for, and after so many samples those that were read; at least 1.
  std::uint32_t learn_samples = 3;
  /// A field that was not read in so many samples in a row is not asked for any more; 0: it always is. One
  /// that is read at least once in so many samples is never given up.
  std::uint32_t narrow_after_samples = 100;
  /// Samples from shared memory, too, have only what was asked for when they were taken, as on another host:
  /// to find out on one host what happens on two. What is asked for is copied. It also holds for a subscriber
  /// whose fields are not recorded.
  bool as_remote = false;
};

/// Durations of 0 mean none: any deadline will do, any liveliness. Others have at least 1 ms.
struct SubscriberOptions {
  TransportChoice transport = TransportChoice::automatic;  ///< the paths that samples may come by
  Reliability reliability = Reliability::best_effort;      ///< reliable matches reliable publishers only
  Durability durability = Durability::volatile_;  ///< transient_local: asks for the last samples from before,
                                                  ///< and for a publisher that retains them
  /// Samples kept until taken, per publisher, 1 to 1,000,000; then the oldest are lost, and counted. Shared
  /// memory keeps 256 at most: a subscriber that asks for more, and may use it, is told so in the log, and
  /// WriterStatus::depth says what is in force. Of publishers that are gone no more than this in all is kept.
  std::uint32_t depth = 8;
  std::chrono::nanoseconds deadline{0};           ///< it expects a sample of each publisher at least so often
  Liveliness liveliness = Liveliness::automatic;  ///< manual_by_topic matches publishers of that kind only
  std::chrono::nanoseconds liveliness_lease{0};   ///< it expects a sign of life at least so often
  /// At most so many samples a second, evenly; 0: all. What is withheld for it is not sent, and is counted
  /// apart from what is lost. Subscriber::set_max_rate_hz() changes it.
  double max_rate_hz = 0;
  /// Samples in shared memory that it may hold of one publisher at the same time, 2 to 256. While it holds as
  /// many, take() gives no more of that publisher, whose next ones wait within `depth`; the subscriber is
  /// told once each time (EventKind::held_too_many), and everybody else goes on.
  std::uint32_t max_held = 256;
  /// How long wait() looks for a sample, and keeps a core busy with it, before it sleeps: one that comes
  /// within that time is had in a microsecond, without what it takes to wake a thread. By default about as
  /// long as that takes, so that looking never costs more than it could have saved. Threads that wait for the
  /// core get it meanwhile, and after a wait that ended without a sample the next one sleeps at once. For a
  /// reader with a core of its own: longer than the period of the samples. With a callback, the thread that
  /// receives by UDP looks so long (1 s at most), as long as datagrams come about as fast as that. Without
  /// effect where it is pollable.
  std::chrono::nanoseconds spin = std::chrono::microseconds(20);
  /// Gives it a Subscriber::file_descriptor(), and its node a thread that tells it what came in shared
  /// memory. Not with a callback.
  bool pollable = false;
  RecordingSettings recording{};  ///< how fields are found out where they are recorded
  EventCallback on_event{};  ///< called with what happens to its pairs, on the node's agent thread: be short
};

}  // namespace sft
