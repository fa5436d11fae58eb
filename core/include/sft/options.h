// The options of nodes, publishers and subscribers. They are plain structs. The function that opens a node,
// publisher or subscriber copies its options, so that later changes to a struct have no effect. If a setting
// cannot work, that function returns an error that names it.
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

/// The paths that samples may take. `automatic` is shared memory between processes of one host, UDP between
/// hosts, and UDP within a host while shared memory is not available.
enum class TransportChoice : std::uint8_t { automatic, shm, udp };

/// debug: the requests of subscribers, whenever they change. info: matches, their paths and the reasons.
/// warning: failures, and settings that can never work. error: functions that stopped working and need a new
/// node to work again.
enum class LogLevel : std::uint8_t { debug, info, warning, error };

/// The UDP settings of one node.
struct UdpSettings {
  /// Says when samples are sent once for several hosts. `automatic`: whenever that puts fewer bytes on the
  /// wire, but not on wireless interfaces (udp_transport/multicast/multicast.md). A switch without IGMP
  /// snooping forwards multicast to all hosts, and loads all their cables: choose `off` there.
  enum class Multicast : std::uint8_t { automatic, off };

  /// 0: any free port for samples, and another one for acknowledgements. Otherwise this port is used for
  /// both.
  std::uint16_t port = 0;
  std::size_t receive_buffer_bytes = 32 * 1024 * 1024;  ///< requested from the kernel, which may grant less
  std::size_t memory_limit_bytes = 256 * 1024 * 1024;   ///< the most for all samples outside of shared memory
  bool use_io_uring = true;                             ///< false: UDP uses plain sockets
  /// The most bytes per second that the node sends by UDP, with the headers of SFT; 0: no limit. Small
  /// samples go first. If a queue is full meanwhile, its oldest samples are dropped, and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// Says whether one copy of a sample may be sent to readers on several hosts together.
  Multicast multicast = Multicast::automatic;
};

/// The settings of one node for shared memory, which the daemon sftd provides.
struct ShmSettings {
  bool start_daemon = true;  ///< true: start sftd if none is running
  /// The path of the executable sftd. Empty: the one that $SFT_DAEMON names; otherwise the first one that is
  /// found beside the program, in ../libexec/sft from there, where SFT is installed, where it was built if it
  /// is a part of another project, and in PATH.
  std::string daemon_path{};
  /// A daemon that this node has started ends when no program has used it for this time; 0: it never ends. A
  /// daemon that was running already, that of a service for example, is not affected.
  std::chrono::seconds daemon_idle_exit = std::chrono::minutes(5);
  /// Users whose sftd is accepted, by name ("robot") or number, besides root, this program's own user, and
  /// the owner of the directory /run/sft. Such a user can read all samples in shared memory and end this
  /// program. The daemon of any other user is not used: samples go by UDP, and NodeStatus::shm says why. A
  /// user that one node accepts is accepted for all nodes of its process.
  std::vector<std::string> daemon_users{};
};

/// How nodes find each other. Nodes of one process may have different settings. Nodes with equal settings, an
/// equal NodeOptions::cyclonedds_config and equal NodeOptions::Threads::discovery share the threads of
/// Cyclone DDS.
struct DiscoverySettings {
  /// Hosts on which nodes are looked for, besides those that multicast reaches: "10.0.0.7", "robot.local", or
  /// with the port of one process, "10.0.0.7:7410". Both sides have to name each other. On each host the
  /// nodes of the first 20 processes are found; the interfaces of a host share this number.
  std::vector<std::string> peers{};
  /// The interfaces on which nodes are looked for and samples received. An entry is a name ("eth0"), an
  /// address ("10.0.0.5", "fe80::1%eth0") or a network ("10.0.0.0/24", "fd00::/64"). Empty: all interfaces
  /// that are up, except bridges and virtual cables of container engines (docker*, veth*, virbr*, br-* and
  /// the like) and interfaces without multicast. Interfaces that appear later or get other addresses are used
  /// within 2 s, whether the list is empty or not. NodeStatus::discovery names those in use and those that
  /// are missing. Nodes of this host always find each other. Interfaces that CYCLONEDDS_URI names replace
  /// these.
  std::vector<std::string> interfaces{};
  /// False: nodes on other hosts are found only by `peers`. Nodes of this host always find each other.
  bool multicast = true;
};

/// The settings of one kind of threads of a node. These threads never inherit a real-time policy or a CPU set
/// from the thread that opens the node: without settings they have the normal policy, and the CPUs that the
/// program was started with.
struct ThreadSettings {
  /// The scheduling policy. `normal` is the default of the system (SCHED_OTHER). `fifo` and `round_robin` are
  /// the real-time policies SCHED_FIFO and SCHED_RR.
  enum class Policy : std::uint8_t { normal, fifo, round_robin };

  /// The numbers of the CPUs on which the threads may run. Empty: the CPUs that the program was started with.
  std::vector<unsigned> cpus{};
  Policy policy = Policy::normal;  ///< real-time policies need a permission: see NodeOptions::Threads
  /// The priority: 1 (lowest) to 99 under a real-time policy, and 0 under the normal one.
  int priority = 0;
  /// The prefix of the threads' names in /proc/PID/task/TID/comm: with "nav-" the thread "sft-udp-recv" is
  /// called "nav-udp-recv". The system keeps 15 characters of a name. Empty: "sft-", and no prefix for
  /// threads of Cyclone DDS.
  std::string name_prefix{};
  friend bool operator==(const ThreadSettings&, const ThreadSettings&) = default;
};

/// The options of one node.
struct NodeOptions {
  /// The threads of a node, by their work. Node::open() fails if the system refuses one of these settings,
  /// and names it: real-time policies need CAP_SYS_NICE, or a limit RLIMIT_RTPRIO of at least the priority.
  struct Threads {
    /// The thread that receives by UDP. It also runs callbacks for samples that came by UDP, as long as these
    /// callbacks are short.
    ThreadSettings receiver{};
    /// The threads that send by UDP what publish() did not send itself, and that wake the readers of this
    /// host if several sleep.
    ThreadSettings sender{};
    /// The thread that negotiates.
    ThreadSettings agent{};
    /// The threads that run callbacks for samples in shared memory, for events and for the log, and that make
    /// file descriptors readable.
    ThreadSettings callbacks{};
    /// The threads of Cyclone DDS. Nodes of one process share them only if these settings are equal. If the
    /// program itself opened the DDS domain, the settings apply only to the link of the loopback.
    ThreadSettings discovery{};
  };

  /// Whether publishers also serve unmodified nodes of DDS and ROS 2 that read their topics, and subscribers
  /// hear those that write to theirs (docs/ros2.md). `automatic`: while a node is found that is not one of
  /// SFT, unless the program speaks DDS itself. A node on this host that was started before is found within
  /// 8 s, and one that uses the loopback only is not found. `always`: as long as the node has a publisher or
  /// a subscriber.
  enum class VanillaDds : std::uint8_t { automatic, always, never };

  /// A callback for lines of the log. It runs on a thread of the node that only handles log lines and events
  /// (event.h), and may call any function of SFT. If several nodes have the same sink, a thread of each node
  /// calls it. A warning or an error that is repeated is written again after a pause, which grows from 5 s to
  /// 11 minutes. Of different lines of a kind about a topic, ten are written at once and then one in 5 s. The
  /// next line says how many were left out.
  using LogSink = std::function<void(LogLevel, std::string_view)>;

  /// The largest domain. DDS derives port numbers from the domain, and has none for larger ones.
  static constexpr std::uint32_t domain_max = 232;

  /// Shown to people; several nodes may have the same name. As in ROS 2 it consists of letters of ASCII,
  /// digits and '_', and does not begin with a digit.
  std::string name = "node";
  /// The namespace, with or without a slash in front: in "left" the topic "points" is "left/points", and the
  /// node "cam" is shown as "left/cam". Empty: none. node.h says to which names it applies.
  std::string namespace_{};
  /// Remapping rules as `ros2 run ... -r` takes them, one in each text: "points:=front/points",
  /// "cam:points:=front" only for nodes with this name or full name ("/left/cam:points:=front"),
  /// "__node:=cam", "__ns:=/left". Names on both sides may be relative, absolute or private. The first rule
  /// that matches a name applies, and its result is not remapped again. The rules of the environment variable
  /// SFT_REMAP, separated by blanks, come before these. A warning of the log names each rule that has matched
  /// no name of the process 5 s after its last node was opened, or when that node was closed.
  std::vector<std::string> remap{};
  /// True: Node::now() is the time of the topic "/clock" (rosgraph_msgs/Clock), as for nodes of ROS 2 with
  /// the parameter of this name. The node subscribes to it, with best effort and a depth of 1. Nothing else
  /// uses that time: rates, conditions, deadlines, leases, timeouts and the stamps of SampleInfo use real
  /// time. The log has a warning if nobody publishes the topic.
  bool use_sim_time = false;
  /// DDS domain of the control topics, 0 to domain_max. Default: $ROS_DOMAIN_ID, otherwise 0.
  std::optional<std::uint32_t> domain{};
  /// Default: that of $SFT_VANILLA_DDS (auto, always, never), otherwise automatic.
  std::optional<VanillaDds> vanilla_dds{};
  /// Settings by which nodes find each other.
  DiscoverySettings discovery{};
  TransportChoice transport = TransportChoice::automatic;  ///< a limit for all its publishers and subscribers
  /// Settings for samples over UDP.
  UdpSettings udp{};
  /// Settings for samples in shared memory.
  ShmSettings shm{};
  /// CPUs, scheduling and names of the threads.
  Threads threads{};
  /// Configuration of Cyclone DDS, as XML or names of files. It takes precedence over the settings of SFT,
  /// except for those that SFT cannot work without. The log and NodeStatus::discovery name overruled
  /// settings. Default: $CYCLONEDDS_URI.
  std::optional<std::string> cyclonedds_config{};
  /// Receives the lines of the log. Without it they go to the standard error of the process, and the library
  /// prints nothing else, except for the line with which a misuse ends the program. Cyclone DDS prints
  /// nothing in a process with a node. Its messages, which have one destination per process, are kept for the
  /// errors that they explain.
  LogSink log{};
  /// The lowest level that is logged. Default: info with `log`, warning without. Without `log` the
  /// environment variable SFT_LOG takes precedence: off, error, warning, info or debug.
  std::optional<LogLevel> log_level{};
};

struct PublisherStatus;

/// The options of one publisher. A duration of 0 means none: no deadline, no end of the lifespan, no lease.
/// Deadlines and leases are at least 1 ms.
struct PublisherOptions {
  TransportChoice transport = TransportChoice::automatic;  ///< the paths that samples may go by
  Reliability reliability = Reliability::best_effort;      ///< qos.h explains it
  Durability durability =
      Durability::volatile_;  ///< transient_local: late subscribers get the last samples, too
  /// The number of samples that are kept for late subscribers if durability is transient_local, 1 to 128.
  /// They occupy memory, also shared memory, and are encoded with all fields, whatever is asked for.
  std::uint32_t history_depth = 1;
  /// The longest time between two samples that the publisher promises. It gets an event when it fails to keep
  /// the promise.
  std::chrono::nanoseconds deadline{0};
  /// The age from which a sample is not delivered any more. If the clocks of two hosts differ, this age is
  /// wrong by the difference.
  std::chrono::nanoseconds lifespan{0};
  Liveliness liveliness =
      Liveliness::automatic;  ///< what asserts that the publisher is alive: its node or the program
  std::chrono::nanoseconds liveliness_lease{0};  ///< the longest time between two signs of life
  /// The longest time, up to 1 s, that publish() waits for reliable subscribers that do not keep up, on this
  /// host and on others, before they lose their oldest sample (DDS: max_blocking_time). In shared memory
  /// publish() waits for room in their queues, and for a free chunk if a subscriber must not use UDP. Over
  /// UDP it waits for acknowledgements of the samples that it keeps for them. At most 10 ms of the time it
  /// waits because it is ahead of the network by more than 8 MB. publish(span) waits no longer in all than
  /// publish() of one sample. It never waits for best-effort subscribers. The default is not to wait: a
  /// subscriber that hangs would delay the program at each publish(), and so all other subscribers.
  std::chrono::nanoseconds max_blocking{0};
  /// The size of the largest encoded message, up to 64 MiB. It is announced, and subscribers allocate no more
  /// memory than that for a sample. A sample that is larger than the largest chunk of shared memory (which
  /// depends on the size of /dev/shm, see "When memory runs short" in docs/operations.md) goes by UDP within
  /// the host, like one for which no chunk is free. Samples of more than 16 MiB take much of
  /// UdpSettings::memory_limit_bytes, on both sides.
  std::size_t max_sample_bytes = 64 * 1024 * 1024;
  /// The most bytes per second that are sent by UDP, over all masks and readers; 0: no limit. Small samples
  /// go first. If a queue is full meanwhile, its oldest samples are dropped, and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// True: publish() copies a sample of more than 16 KiB for readers on other hosts and returns; a thread of
  /// the node sends it. False: publish() itself sends it to one process at least, and copies nothing, so that
  /// it arrives earlier. The option changes nothing where max_blocking is not 0.
  bool asynchronous = false;
  /// Called with the status of all readers after readers came, left or changed what they ask for, once the
  /// change is in force. (on_event reports what happened to each.) It runs on the thread for events
  /// (event.h). Like any callback it may be called before the function that opens the publisher has returned.
  /// It may publish, if no other thread does so at the same time.
  std::function<void(const PublisherStatus&)> on_readers_changed{};
  Event::Callback on_event{};  ///< called with each event of the publisher, on the node's thread for events
};

/// The options of one subscriber. A duration of 0 means none: any deadline and any liveliness fit. Other
/// durations are at least 1 ms.
struct SubscriberOptions {
  /// Settings of subscribers whose fields are recorded. A sample counts when it is released.
  struct Recording {
    /// The number of samples, at least 1, for which the subscriber asks for all fields at first. Then it asks
    /// for the fields that were read.
    std::uint32_t learn_samples = 3;
    /// A field that was not read in this number of consecutive samples is no longer asked for. 0: a field
    /// that was asked for once is always asked for.
    std::uint32_t narrow_after_samples = 100;
    /// True: samples from shared memory have only the fields that were asked for when they were taken, as
    /// they would on another host. So a program can be tried on one host before it runs on two. Whole
    /// fields are copied for that; parts of fields stay where they are. This also applies to a subscriber
    /// whose fields are not recorded.
    bool as_remote = false;
  };

  TransportChoice transport = TransportChoice::automatic;  ///< the paths that samples may come by
  Reliability reliability = Reliability::best_effort;      ///< reliable matches reliable publishers only
  /// transient_local: requests the last samples from before, and matches only publishers that retain them.
  Durability durability = Durability::volatile_;
  /// The number of samples of each publisher that are kept until they are taken, 1 to 1,000,000. If more
  /// arrive, the oldest are lost, and counted. Shared memory keeps at most 256. If a subscriber that may use
  /// it asks for more, the log says so, and SubscriberStatus::Writer::depth is the number in force. Of all
  /// departed publishers together no more than this number is kept.
  std::uint32_t depth = 8;
  /// The bytes of samples of each publisher that are kept until they are taken; 0: no limit but `depth`. If
  /// more arrive, the oldest samples are lost, too, but the newest one always stays. So a subscriber that is
  /// slow, or does not take at all, leaves the memory that large samples need to other subscribers. In shared
  /// memory the number is rounded down to a power of two of 64 KiB or more.
  std::size_t depth_bytes = 32 * 1024 * 1024;
  std::chrono::nanoseconds deadline{0};           ///< the longest time between two samples of a publisher
  Liveliness liveliness = Liveliness::automatic;  ///< manual_by_topic matches publishers of that kind only
  std::chrono::nanoseconds liveliness_lease{
      0};  ///< the longest time between two signs of life of a publisher
  /// The most samples per second of each selection, evenly spaced, from slowest_rate_hz to fastest_rate_hz;
  /// 0: all. Further samples are withheld: they are not sent, and are counted separately from lost ones.
  /// Subscriber::set_max_rate_hz() changes the rate.
  double max_rate_hz = 0;
  /// Says which parts of the declared fields are needed, and when a sample is needed: "data{x,y,z}[::4]", "@
  /// percentage > 20 or every 10 s", or both (TypeSupport::parse_selection()). Fields that it does not name
  /// are sent as they are declared. If fields are recorded, it may have conditions only. Empty: whole fields
  /// of every sample. Subscriber::set_selection() changes it. For a subscriber with sft::selected it also
  /// names the fields: "header.stamp, data{x,y,z}"; if it names none, all fields are meant. Not for
  /// subscribers of types that the program was not compiled with: the function that opens them takes such a
  /// text.
  std::string selection{};
  /// Further selections, as texts of the same kind: "pose.pose @ at most 100 Hz" as the first selection, and
  /// "pose.covariance @ at most 1 Hz" here. A message arrives once for each selection that lets it pass.
  /// SampleInfo::selection says for which one a sample came: 0 is the first selection, 1 the first of these.
  /// The oldest of all samples that have arrived is delivered first. The samples of one message are delivered
  /// in the order of the selections, if all have arrived. A sample may have more fields than its selection
  /// asks for, since one encoding may serve several selections, and a sample in shared memory has all.
  ///
  /// To publishers and tools each selection is a subscriber of its own, which matches and connects alone.
  /// Publisher::wait_for_subscribers() and all limits count each selection. Each selection has its own
  /// status. `depth`, `max_held` and `max_rate_hz` apply to each selection; `deadline` applies to the first
  /// one only. It is an error to give further selections if fields are recorded.
  std::vector<std::string> further_selections{};
  static constexpr std::size_t selections_max = 16;    ///< selections per subscriber, including the first one
  static constexpr double slowest_rate_hz = 0.001;     ///< the smallest max_rate_hz, apart from 0
  static constexpr double fastest_rate_hz = 100'000;   ///< the greatest max_rate_hz
  static constexpr std::uint32_t max_held_least = 2;   ///< one sample is held while the next is taken
  static constexpr std::uint32_t max_held_most = 256;  ///< the limit of iceoryx
  /// The number of samples in shared memory of one publisher that the program may hold at the same time.
  /// While it holds that many, take() returns no more of that publisher; its next samples wait within
  /// `depth`. A sample with parts of fields holds the whole sample that contains them. The subscriber gets an
  /// event each time (Event::Kind::held_too_many). Other subscribers are not affected.
  std::uint32_t max_held = max_held_most;
  /// How long wait() spins, which keeps a core busy, before it sleeps. A sample that comes within that time
  /// is taken within a microsecond, because no thread has to be woken. The default is about the time that it
  /// takes to wake a thread, so that spinning never costs more than it can save. Other threads that wait for
  /// the core get it meanwhile. After a wait that ended without a sample, or took more than ten times as long
  /// as this, the next wait() sleeps at once. For a reader with a core of its own choose more than the period
  /// of the samples. With a callback, the thread that receives by UDP spins for this time (1 s at most), as
  /// long as datagrams come about as often. It has no effect on a subscriber that is pollable.
  std::chrono::nanoseconds spin = std::chrono::microseconds(20);
  /// True: the subscriber has a Subscriber::file_descriptor(), and its node has a thread that makes it
  /// readable for samples in shared memory. Must not be combined with a callback.
  bool pollable = false;
  Recording recording{};       ///< how fields are recorded
  Event::Callback on_event{};  ///< called with each event of the subscriber, on the node's thread for events
};

}  // namespace sft
