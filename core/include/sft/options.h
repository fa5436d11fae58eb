// The options of nodes, publishers and subscribers. They are plain structs. The function that opens a node,
// publisher or subscriber copies its options, so that later changes to a struct have no effect. If a setting
// cannot work, that function returns an error that names the setting.
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

/// The levels of the log. debug: the requests of subscribers, whenever they change. info: matches, their
/// paths and the reasons. warning: failures, and settings that can never work. error: functions that stopped
/// working and need a new node to work again.
enum class LogLevel : std::uint8_t { debug, info, warning, error };

/// The UDP settings of one node.
struct UdpSettings {
  /// Says when samples are sent once for several hosts. `automatic`: whenever that puts fewer bytes on the
  /// wire, but not on wireless interfaces (udp_transport/multicast/multicast.md). A switch without IGMP
  /// snooping forwards multicast to all hosts, and loads all their cables: choose `off` there.
  enum class Multicast : std::uint8_t { automatic, off };

  /// The UDP port. 0: any free port for samples, and another one for acknowledgements. Otherwise this port is
  /// used for both.
  std::uint16_t port = 0;
  /// The size requested from the kernel, which may grant less.
  std::size_t receive_buffer_bytes = 32 * 1024 * 1024;
  /// The most bytes for all samples outside of shared memory.
  std::size_t memory_limit_bytes = 256 * 1024 * 1024;
  bool use_io_uring = true;  ///< false: UDP uses plain sockets
  /// The most bytes per second that the node sends by UDP, with the headers of SFT; 0: no limit. Small
  /// samples go first. If a queue is full meanwhile, its oldest samples are dropped, and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// Decides if one copy of a sample may be sent to readers on several hosts together.
  Multicast multicast = Multicast::automatic;
};

/// The settings of one node for shared memory, which the daemon sftd provides.
struct ShmSettings {
  bool start_daemon = true;  ///< true: start sftd if none is running
  /// The path of the executable sftd. If it is empty, SFT uses the path in $SFT_DAEMON, or else the first
  /// sftd that it finds in these places: beside the program, in ../libexec/sft from there, where SFT is
  /// installed, where SFT was built if it is a part of another project, and in PATH.
  std::string daemon_path{};
  /// The time after which a daemon that this node has started ends if no program uses it; 0: it never ends. A
  /// daemon that was running already, for example as a service, is not affected.
  std::chrono::seconds daemon_idle_exit = std::chrono::minutes(5);
  /// Users whose sftd is accepted, by name ("robot") or number, besides root, this program's own user, and
  /// the owner of the directory /run/sft. Caution: such a user can read all samples in shared memory and end
  /// this program. The daemon of any other user is not used: samples go by UDP, and NodeStatus::shm says why.
  /// A user that one node accepts is accepted for all nodes of its process.
  std::vector<std::string> daemon_users{};
};

/// The settings by which nodes find each other. Nodes of one process may have different settings. Nodes share
/// the threads of Cyclone DDS if their settings, NodeOptions::cyclonedds_config and
/// NodeOptions::Threads::discovery are equal.
struct DiscoverySettings {
  /// Hosts on which nodes are looked for, besides those that multicast reaches: "10.0.0.7", "robot.local", or
  /// with the port of one process, "10.0.0.7:7410". Both sides have to name each other. On each host the
  /// nodes of the first 20 processes are found; the interfaces of a host share this number.
  std::vector<std::string> peers{};
  /// The interfaces on which nodes are looked for and samples received. An entry is a name ("eth0"), an
  /// address ("10.0.0.5", "fe80::1%eth0") or a network ("10.0.0.0/24", "fd00::/64"). Empty: all interfaces
  /// that are up, except bridges and virtual cables of container engines (docker*, veth*, virbr*, br-* and
  /// the like) and interfaces without multicast. Interfaces that appear later or get other addresses are used
  /// within 2 s, whether the list is empty or not. NodeStatus::discovery names the interfaces in use and the
  /// missing ones. Nodes of this host always find each other. If CYCLONEDDS_URI names interfaces, they
  /// replace this list.
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
  /// and its error names the setting. Real-time policies need CAP_SYS_NICE, or a limit RLIMIT_RTPRIO of at
  /// least the priority.
  struct Threads {
    /// The thread that receives by UDP. It also runs callbacks for samples that came by UDP, as long as these
    /// callbacks are short.
    ThreadSettings receiver{};
    /// The threads that send by UDP the samples that publish() left to them, and that wake the readers of
    /// this host if several readers sleep.
    ThreadSettings sender{};
    /// The thread that negotiates.
    ThreadSettings agent{};
    /// The threads that run callbacks for samples in shared memory, for events and for the log, and that make
    /// file descriptors readable.
    ThreadSettings callbacks{};
    /// The threads of Cyclone DDS. Nodes of one process share them only if these settings are equal.
    ThreadSettings discovery{};
  };

  /// The conditions under which publishers also serve unmodified nodes of DDS and ROS 2 that read their
  /// topics, and subscribers hear those that write to their topics (docs/ros2.md). `automatic`: while a node
  /// that is not one of SFT is found, unless the program uses DDS itself. A node on this host that was
  /// started earlier is found within 8 s. A node that uses the loopback only is not found. `always`: as long
  /// as the node has a publisher or a subscriber.
  enum class VanillaDds : std::uint8_t { automatic, always, never };

  /// A callback for lines of the log. It runs on a thread of the node that only handles log lines and events
  /// (event.h), and may call any function of SFT. If several nodes have the same sink, a thread of each node
  /// calls it. A warning or an error that is repeated is written again after a pause, which grows from 5 s to
  /// 11 minutes. Of different lines of a kind about a topic, ten are written at once and then one every 5 s.
  /// The next line tells the number of lines that were left out.
  using LogSink = std::function<void(LogLevel, std::string_view)>;

  /// The largest domain. DDS derives port numbers from the domain, and has none for larger ones.
  static constexpr std::uint32_t domain_max = 232;

  /// The name that is shown to people; several nodes may have the same name. As in ROS 2 it consists of ASCII
  /// letters, digits and '_', and does not begin with a digit.
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
  /// time. The log has a warning if the topic has no publisher.
  bool use_sim_time = false;
  /// The DDS domain of the control topics, 0 to domain_max. Default: $ROS_DOMAIN_ID, otherwise 0.
  std::optional<std::uint32_t> domain{};
  /// The choice for unmodified nodes. Default: the value of $SFT_VANILLA_DDS (auto, always, never), otherwise
  /// automatic.
  std::optional<VanillaDds> vanilla_dds{};
  /// Settings by which nodes find each other.
  DiscoverySettings discovery{};
  /// A limit for all publishers and subscribers of the node.
  TransportChoice transport = TransportChoice::automatic;
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
  /// Receives the lines of the log. Without it the lines go to the standard error of the process, and the
  /// library prints nothing else, except for the line with which a misuse ends the program. Cyclone DDS
  /// prints nothing in a process with a node. Its messages, which have one destination per process, are kept
  /// for the errors that they explain.
  LogSink log{};
  /// The lowest level that is logged. Default: info with `log`, warning without. Without `log` the
  /// environment variable SFT_LOG takes precedence: off, error, warning, info or debug.
  std::optional<LogLevel> log_level{};
};

struct PublisherStatus;

/// The options of one publisher. A duration of 0 means none: no deadline, no end of the lifespan, no lease.
/// Deadlines and leases are at least 1 ms.
struct PublisherOptions {
  TransportChoice transport = TransportChoice::automatic;  ///< the paths that samples may take
  Reliability reliability = Reliability::best_effort;      ///< the handling of lost samples, see qos.h
  /// The durability. transient_local: late subscribers also get the last samples.
  Durability durability = Durability::volatile_;
  /// The number of samples that are kept for late subscribers if durability is transient_local, 1 to 128.
  /// They occupy memory, also shared memory. They are encoded with all fields, even if subscribers ask for
  /// fewer.
  std::uint32_t history_depth = 1;
  /// The longest time between two samples that the publisher promises. The publisher gets an event whenever
  /// it breaks the promise.
  std::chrono::nanoseconds deadline{0};
  /// The age at which a sample is not delivered any more. If the clocks of two hosts differ, this age is
  /// wrong by the difference.
  std::chrono::nanoseconds lifespan{0};
  /// Decides if the node or the program asserts that the publisher is alive.
  Liveliness liveliness = Liveliness::automatic;
  /// The longest time between two assertions that the publisher is alive.
  std::chrono::nanoseconds liveliness_lease{0};
  /// The longest time, up to 1 s, that publish() waits for reliable subscribers that do not keep up, on this
  /// host and on others, before they lose their oldest sample (DDS: max_blocking_time). In shared memory
  /// publish() waits for room in their queues, and for a free chunk if a subscriber must not use UDP. Over
  /// UDP it waits for acknowledgements of the samples that it keeps for them. If it is ahead of the network
  /// by more than 8 MB, it waits for the network, too, for at most 10 ms of this time. A call of
  /// publish(span) waits no longer in all than publish() of one sample. publish() never waits for best-effort
  /// subscribers. The default is not to wait: a subscriber that hangs would delay the program at each
  /// publish(), and so all other subscribers.
  std::chrono::nanoseconds max_blocking{0};
  /// The size of the largest encoded message in bytes, up to 64 MiB. The size is announced, and subscribers
  /// allocate no more memory than that for a sample. A sample that is larger than the largest chunk of shared
  /// memory goes by UDP within the host, like a sample for which no chunk is free. (The largest chunk depends
  /// on the size of /dev/shm, see "When memory runs short" in docs/operations.md.) Samples of more than 16
  /// MiB take much of UdpSettings::memory_limit_bytes, on both sides.
  std::size_t max_sample_bytes = 64 * 1024 * 1024;
  /// The most bytes per second that are sent by UDP, over all masks and readers; 0: no limit. Small samples
  /// go first. If a queue is full meanwhile, its oldest samples are dropped, and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// True: publish() copies a sample of more than 16 KiB for readers on other hosts and returns; a thread of
  /// the node sends the copy. False: publish() itself sends the sample to at least one process, without a
  /// copy, so that it arrives earlier. The option has no effect if max_blocking is not 0.
  bool asynchronous = false;
  /// A callback that gets the status of all readers after readers joined, left or changed their requests,
  /// once the change is in force. (on_event reports each change by itself.) It runs on the thread for events
  /// (event.h). Like any callback it may be called before the function that opens the publisher has returned.
  /// It may publish, if no other thread does so at the same time.
  std::function<void(const PublisherStatus&)> on_readers_changed{};
  Event::Callback on_event{};  ///< called with each event of the publisher, on the node's thread for events
};

/// The options of one subscriber. A duration of 0 means none: any deadline and any liveliness fit. Other
/// durations are at least 1 ms.
struct SubscriberOptions {
  /// The settings of subscribers whose fields are recorded. A sample counts when it is released.
  struct Recording {
    /// The number of samples, at least 1, for which the subscriber asks for all fields at first. Then it asks
    /// for the fields that were read.
    std::uint32_t learn_samples = 3;
    /// A field that was not read in this number of consecutive samples is no longer asked for. 0: a field
    /// that was asked for once is always asked for.
    std::uint32_t narrow_after_samples = 100;
    /// True: samples from shared memory have only the fields that were asked for at the time of take(), as on
    /// another host. So a program can be tried on one host before it runs on two. Whole fields are copied for
    /// that; parts of fields stay where they are. The setting also applies to a subscriber whose fields are
    /// not recorded.
    bool as_remote = false;
  };

  TransportChoice transport = TransportChoice::automatic;  ///< the paths that samples may take
  /// A reliable subscriber matches reliable publishers only.
  Reliability reliability = Reliability::best_effort;
  /// transient_local: the subscriber requests the last samples from before it joined, and matches only
  /// publishers that retain samples.
  Durability durability = Durability::volatile_;
  /// The number of samples of each publisher that are kept until they are taken, 1 to 1,000,000. If more
  /// arrive, the oldest ones are lost, and counted. Shared memory keeps at most 256 samples. If a subscriber
  /// that may use shared memory asks for more, the log says so, and SubscriberStatus::Writer::depth is the
  /// number in force. Of all departed publishers together, at most this number of samples is kept.
  std::uint32_t depth = 8;
  /// The bytes of samples of each publisher that are kept until they are taken; 0: no limit but `depth`. If
  /// more arrive, the oldest samples are lost, too, but the newest one always stays. So a subscriber that is
  /// slow, or takes nothing, leaves the memory that large samples need to other subscribers. In shared memory
  /// the number is rounded down to a power of two of at least 64 KiB.
  std::size_t depth_bytes = 32 * 1024 * 1024;
  std::chrono::nanoseconds deadline{0};  ///< the longest time between two samples of a publisher
  /// A manual_by_topic subscriber matches publishers of that kind only.
  Liveliness liveliness = Liveliness::automatic;
  /// The longest time between two assertions that a publisher is alive.
  std::chrono::nanoseconds liveliness_lease{0};
  /// The most samples per second of each selection, evenly spaced, from slowest_rate_hz to fastest_rate_hz;
  /// 0: all. Further samples are withheld: they are not sent, and are counted separately from lost ones.
  /// Subscriber::set_max_rate_hz() changes the rate.
  double max_rate_hz = 0;
  /// The parts of the declared fields that are needed, the conditions under which a sample is needed, or
  /// both: "data{x,y,z}[::4]", "@ percentage > 20 or every 10 s" (TypeSupport::parse_selection()). Fields
  /// that the text does not name are sent as they are declared. If fields are recorded, the text may have
  /// conditions only. If it is empty, whole fields of every sample are sent. Subscriber::set_selection()
  /// changes the selection. For a subscriber with sft::selected the text also names the fields:
  /// "header.stamp, data{x,y,z}"; if it names none, all fields are meant. The option is not for subscribers
  /// of types that the program was not compiled with: the function that opens them takes such a text.
  std::string selection{};
  /// Further selections, as texts of the same kind: "pose.pose @ at most 100 Hz" as the first selection, and
  /// "pose.covariance @ at most 1 Hz" here. A message arrives once for each selection that lets it pass.
  /// SampleInfo::selection is the number of the sample's selection: 0 is the first selection, 1 the first one
  /// of this list. The oldest of all samples that have arrived is delivered first. The samples of one message
  /// are delivered in the order of the selections, if all have arrived. A sample may have more fields than
  /// its selection asks for, since one encoding may serve several selections, and a sample in shared memory
  /// has all.
  ///
  /// To publishers and tools each selection is a subscriber of its own, which matches and connects alone.
  /// Publisher::wait_for_subscribers() and all limits count each selection. Each selection has its own
  /// status. `depth`, `max_held` and `max_rate_hz` apply to each selection; `deadline` applies to the first
  /// one only. It is an error to give further selections if fields are recorded.
  std::vector<std::string> further_selections{};
  static constexpr std::size_t selections_max = 16;   ///< selections per subscriber, including the first one
  static constexpr double slowest_rate_hz = 0.001;    ///< the smallest max_rate_hz, apart from 0
  static constexpr double fastest_rate_hz = 100'000;  ///< the greatest max_rate_hz
  /// The least max_held: one sample is held while the next is taken.
  static constexpr std::uint32_t max_held_least = 2;
  /// The greatest max_held, which is the limit of iceoryx.
  static constexpr std::uint32_t max_held_most = 256;
  /// The number of samples in shared memory of one publisher that the program may hold at the same time.
  /// While it holds that number, take() returns no more samples of that publisher; its next samples wait
  /// within `depth`. A sample with parts of fields holds the whole sample that contains them. The subscriber
  /// gets an event each time (Event::Kind::held_too_many). Other subscribers are not affected.
  std::uint32_t max_held = max_held_most;
  /// The time for which wait() spins, which keeps a core busy, before it sleeps. A sample that comes within
  /// that time is taken within a microsecond, because no thread has to be woken. The default is about the
  /// time that it takes to wake a thread, so that spinning never costs more than it can save. Other threads
  /// that wait for the core get it meanwhile. The next wait() sleeps at once after a wait that ended without
  /// a sample or took more than ten times this time. For a reader with a core of its own choose more than the
  /// period of the samples. For a subscriber with a callback, the thread that receives by UDP spins for this
  /// time (1 s at most), as long as datagrams come about as often. The option has no effect on a subscriber
  /// that is pollable.
  std::chrono::nanoseconds spin = std::chrono::microseconds(20);
  /// True: the subscriber has a Subscriber::file_descriptor(), and its node has a thread that makes it
  /// readable for samples in shared memory. Must not be combined with a callback.
  bool pollable = false;
  Recording recording{};       ///< the settings for recorded fields
  Event::Callback on_event{};  ///< called with each event of the subscriber, on the node's thread for events
};

}  // namespace sft
