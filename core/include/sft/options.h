// The options of nodes, publishers and subscribers. They are plain structs. The function that opens a node,
// publisher or subscriber copies its options, so that later changes to a struct have no effect. If a setting
// cannot work, that function returns an error that names the setting.
#pragma once

#include <chrono>
#include <compare>
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

/// The levels of the log. debug: changed requests of subscribers. info: matches, their paths and the
/// reasons. warning: failures, and settings that can never work. error: functions that stopped working and
/// need a new node to work again.
enum class LogLevel : std::uint8_t { debug, info, warning, error };

/// The UDP settings of one node.
struct UdpSettings {
  /// Decides when a sample is sent once for several hosts. `automatic`: whenever this reduces the bytes on
  /// the wire, except on wireless interfaces (udp_transport/multicast/multicast.md). A switch without IGMP
  /// snooping forwards multicast to all hosts, and loads all their cables: choose `off` there.
  enum class Multicast : std::uint8_t { automatic, off };

  /// The UDP port. 0: any free port for samples, and another free port for acknowledgements. Any other
  /// number: this port is used for both.
  std::uint16_t port = 0;
  /// The size of the receive buffer that is requested from the kernel, which may grant less.
  std::size_t receive_buffer_bytes = 32 * 1024 * 1024;
  /// The maximum size in bytes of all samples of the node that are not in shared memory.
  std::size_t memory_limit_bytes = 256 * 1024 * 1024;
  bool use_io_uring = true;  ///< false: UDP uses plain sockets
  /// The maximum number of bytes per second that the node sends by UDP, including the headers of SFT; 0: no
  /// limit. Small samples are sent first. If the limit makes a queue full, its oldest samples are dropped
  /// and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// Decides if one copy of a sample may be sent to readers on several hosts together.
  Multicast multicast = Multicast::automatic;
};

/// The settings of one node for shared memory, which the daemon sftd provides.
struct ShmSettings {
  bool start_daemon = true;  ///< true: start sftd if none is running
  /// The path of the executable sftd. If it is empty, SFT uses the path in $SFT_DAEMON. If there is none
  /// either, SFT uses the first sftd in these places: the directory of the program, ../libexec/sft relative
  /// to it, the installation of SFT, the build directory of SFT if it is a part of another project, and
  /// PATH.
  std::string daemon_path{};
  /// The time after which a daemon that this node has started ends if no program uses it; 0: it never ends. A
  /// daemon that was running already, for example as a service, is not affected.
  std::chrono::seconds daemon_idle_exit = std::chrono::minutes(5);
  /// Users whose sftd is accepted, by name ("robot") or number. Root, this program's own user, and the
  /// owner of the directory /run/sft are always accepted. Caution: such a user can read all samples in
  /// shared memory and end this program. The daemon of any other user is not used: samples are sent by UDP
  /// then, and NodeStatus::shm says why. A user that one node accepts is accepted for all nodes of its
  /// process.
  std::vector<std::string> daemon_users{};
};

/// The settings by which nodes find each other. Nodes of one process may have different settings. Nodes share
/// the threads of Cyclone DDS if their settings, NodeOptions::cyclonedds_config and
/// NodeOptions::Threads::discovery are equal.
struct DiscoverySettings {
  /// Hosts that are searched for nodes, in addition to those that multicast reaches: "10.0.0.7",
  /// "robot.local", or with the port of one process, "10.0.0.7:7410". The nodes on both sides have to name
  /// each other's host. On each host the nodes of the first 20 processes are found; the interfaces of a
  /// host share this number.
  std::vector<std::string> peers{};
  /// The interfaces on which nodes are found and samples are received. An entry is a name ("eth0"), an
  /// address ("10.0.0.5", "fe80::1%eth0") or a network ("10.0.0.0/24", "fd00::/64"). Empty: all interfaces
  /// that are up, except bridges and virtual cables of container engines (docker*, veth*, virbr*, br-* and
  /// the like) and interfaces without multicast. Interfaces that appear later or get other addresses are
  /// used within 2 s, whether the list is empty or not. NodeStatus::discovery names the interfaces in use
  /// and the missing ones. Nodes of this host always find each other. If CYCLONEDDS_URI names interfaces,
  /// they replace this list.
  std::vector<std::string> interfaces{};
  /// False: nodes on other hosts are found only by `peers`. Nodes of this host always find each other.
  bool multicast = true;
};

/// The settings of one kind of threads of a node. Threads of a node never inherit a real-time policy or a
/// CPU set from the thread that opens the node. Without settings they have the normal policy, and the CPUs
/// with which the program was started.
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
  friend auto operator<=>(const ThreadSettings&, const ThreadSettings&) = default;
};

/// The options of one node.
struct NodeOptions {
  /// The threads of a node, by their work. Node::open() fails if the system refuses one of these settings,
  /// and its error names the setting. Real-time policies need CAP_SYS_NICE, or a limit RLIMIT_RTPRIO of at
  /// least the priority.
  struct Threads {
    /// The thread that receives by UDP. It also runs callbacks for samples that came by UDP, as long as the
    /// callbacks are short.
    ThreadSettings receiver{};
    /// The threads that send samples by UDP which publish() has not sent itself, and that wake the readers
    /// on this host if several readers sleep.
    ThreadSettings sender{};
    /// The agent: the thread that negotiates with other nodes, and opens and closes ports.
    ThreadSettings agent{};
    /// The threads that run callbacks for samples in shared memory, for events and for the log, and that make
    /// file descriptors readable.
    ThreadSettings callbacks{};
    /// The threads of Cyclone DDS. Nodes of one process share them only if these settings are equal.
    ThreadSettings discovery{};
  };

  /// The conditions under which publishers also serve unmodified nodes of DDS and ROS 2 that read their
  /// topics, and subscribers receive from such nodes that write to their topics (docs/ros2.md).
  /// `automatic`: while a node that is not one of SFT is found, unless the program uses DDS itself. A node
  /// on this host that was started earlier is found within 8 s. A node that uses only the loopback is not
  /// found. `always`: as long as the node has a publisher or a subscriber.
  enum class VanillaDds : std::uint8_t { automatic, always, never };

  /// The names of topics and types in DDS. `ros2`: those that ROS 2 gives them, "rt/points" and
  /// "sensor_msgs::msg::dds_::PointCloud2_". `plain`: their own names, "points" and
  /// "sensor_msgs::msg::PointCloud2", for programs of DDS that know nothing of ROS 2.
  enum class DdsNames : std::uint8_t { ros2, plain };

  /// A callback for lines of the log. It runs on a thread of the node that only handles log lines and
  /// events (event.h), and may call any function of SFT. If several nodes have the same sink, a thread of
  /// each node calls it. A repeated warning or error is written again only after a pause, which grows from
  /// 5 s to 11 minutes. Of different lines of one kind about one topic, at most ten are written at once,
  /// and then one every 5 s. The next line contains the number of omitted lines.
  using LogSink = std::function<void(LogLevel, std::string_view)>;

  /// The greatest domain number. DDS derives port numbers from the domain, and has no ports for greater
  /// numbers.
  static constexpr std::uint32_t domain_max = 232;

  /// The name that is shown to people; several nodes may have the same name. As in ROS 2 it consists of ASCII
  /// letters, digits and '_', and does not begin with a digit.
  std::string name = "node";
  /// The namespace, with or without a leading slash: in "left" the topic "points" is "left/points", and the
  /// node "cam" is shown as "left/cam". Empty: no namespace. node.h says to which names it applies.
  std::string namespace_{};
  /// Remapping rules as `ros2 run ... -r` takes them, one in each text: "points:=front/points",
  /// "cam:points:=front" (only for nodes with this name) or "/left/cam:points:=front" (with this full
  /// name), "__node:=cam", "__ns:=/left". Names on both sides may be relative, absolute or private. The
  /// first rule that matches a name applies, and its result is not remapped again. The rules of the
  /// environment variable SFT_REMAP, separated by blanks, are applied before these. A warning of the log
  /// names each rule that has matched no name of the process 5 s after its last node was opened, or when
  /// that node was closed.
  std::vector<std::string> remap{};
  /// True: Node::now() is the time of the topic "/clock" (rosgraph_msgs/Clock), as for nodes of ROS 2 with
  /// the parameter of this name. The node subscribes to it, with best effort and a depth of 1. Nothing else
  /// uses that time: rates, conditions, deadlines, leases, timeouts and the stamps of SampleInfo use real
  /// time. If the topic has no publisher, a warning is logged.
  bool use_sim_time = false;
  /// The DDS domain of the control topics, 0 to domain_max. Default: $ROS_DOMAIN_ID, otherwise 0.
  std::optional<std::uint32_t> domain{};
  /// The conditions under which unmodified nodes of DDS and ROS 2 are served. Default: the value of
  /// $SFT_VANILLA_DDS (auto, always, never), otherwise automatic.
  std::optional<VanillaDds> vanilla_dds{};
  /// The names by which unmodified nodes are served and heard. Default: the value of $SFT_DDS_NAMES (ros2,
  /// plain), otherwise ros2.
  std::optional<DdsNames> dds_names{};
  /// Settings by which nodes find each other.
  DiscoverySettings discovery{};
  /// The paths that samples of all publishers and subscribers of the node may take. Their own options can
  /// only restrict this further.
  TransportChoice transport = TransportChoice::automatic;
  /// Settings for samples over UDP.
  UdpSettings udp{};
  /// Settings for samples in shared memory.
  ShmSettings shm{};
  /// CPUs, scheduling and names of the threads.
  Threads threads{};
  /// Configuration of Cyclone DDS, as XML or names of files. It takes precedence over the settings of SFT,
  /// except for settings that SFT requires. The log and NodeStatus::discovery name the settings of the user
  /// that have no effect. Default: $CYCLONEDDS_URI.
  std::optional<std::string> cyclonedds_config{};
  /// Receives the lines of the log. If it is empty, the lines are written to the standard error of the
  /// process. The library prints nothing else, except for one line when a misuse ends the program. Cyclone
  /// DDS prints nothing in a process with a node. Its messages, which have only one destination per
  /// process, are used in the texts of the errors that they explain.
  LogSink log{};
  /// The minimum level that is logged. Default: info if `log` is set, otherwise warning. If `log` is not
  /// set, the environment variable SFT_LOG takes precedence: off, error, warning, info or debug.
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
  /// The number of samples that are kept for late subscribers if durability is transient_local, from 1 to
  /// 128. These samples occupy memory, including shared memory. They are encoded with all fields, even if
  /// subscribers request fewer.
  std::uint32_t history_depth = 1;
  /// The maximum time between two samples that the publisher promises. The publisher gets an event whenever
  /// it breaks the promise.
  std::chrono::nanoseconds deadline{0};
  /// The age at which a sample is not delivered any more. If the clocks of two hosts differ, the effective
  /// age is wrong by the difference.
  std::chrono::nanoseconds lifespan{0};
  /// Decides if the node or the program asserts that the publisher is alive.
  Liveliness liveliness = Liveliness::automatic;
  /// The maximum time between two assertions that the publisher is alive.
  std::chrono::nanoseconds liveliness_lease{0};
  /// The maximum time, up to 1 s, for which publish() waits for reliable subscribers that do not keep up,
  /// on this host and on others, before their oldest sample is lost (DDS: max_blocking_time). In shared
  /// memory, publish() waits until their queues have a free slot, and also for a free chunk if a subscriber
  /// must not use UDP. Over UDP it waits for acknowledgements of the samples that it keeps for them. If
  /// more than 8 MB have not been sent yet, publish() also waits for the network, for at most 10 ms of this
  /// time. A call of publish(span) as a whole waits no longer than publish() of one sample. publish() never
  /// waits for best-effort subscribers. The default is not to wait, because a subscriber that hangs would
  /// delay each publish(), and thus all other subscribers.
  std::chrono::nanoseconds max_blocking{0};
  /// The maximum size in bytes of an encoded message, up to 64 MiB. This size is announced, and subscribers
  /// allocate no more memory for a sample. A sample that is larger than the largest chunk of shared memory
  /// is sent by UDP even within the host, like a sample for which no chunk is free. (The largest chunk
  /// depends on the size of /dev/shm, see "When memory runs short" in docs/operations.md.) Samples of more
  /// than 16 MiB take much of UdpSettings::memory_limit_bytes, on both sides.
  std::size_t max_sample_bytes = 64 * 1024 * 1024;
  /// The maximum number of bytes per second that the publisher sends by UDP, to all readers together; 0: no
  /// limit. Small samples are sent first. If the limit makes a queue full, its oldest samples are dropped
  /// and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// The maximum size in bytes of the samples that the publisher keeps for each reliable subscriber that it
  /// serves by UDP, until the subscriber has acknowledged them; at most 64 MiB. The latest three samples are
  /// kept in any case. After an interruption of a slow link, what was kept is sent before new samples: choose
  /// less if late samples are worth nothing. What is given up counts as lost.
  std::size_t resend_bytes = 64 * 1024 * 1024;
  /// Decides which large samples of several publishers of the node are sent first by UDP: those of the
  /// publisher with the greatest number. Small samples are sent before all large ones.
  std::int8_t priority = 0;
  /// True: publish() copies a sample of more than 16 KiB for readers on other hosts and returns; then a
  /// thread of the node sends the copy. False: publish() itself sends the sample to at least one process,
  /// without a copy, so that it arrives earlier. The option has no effect if max_blocking is not 0.
  bool asynchronous = false;
  /// A callback that receives the status of all readers after readers have joined or left or changed their
  /// requests, once the change is in force. (on_event reports each change separately.) It runs on the
  /// thread for events (event.h). Like any callback it may be called before the function that opens the
  /// publisher has returned. It may publish, provided that no other thread does so at the same time.
  std::function<void(const PublisherStatus&)> on_readers_changed{};
  Event::Callback on_event{};  ///< called with each event of the publisher, on the node's thread for events
};

/// The options of one subscriber. A duration of 0 means no requirement: any deadline and any lease are
/// accepted. Other durations are at least 1 ms.
struct SubscriberOptions {
  /// The settings of subscribers whose fields are recorded. A sample counts once it is released.
  struct Recording {
    /// The number of samples, at least 1, for which the subscriber requests all fields at first. After that
    /// it requests only the fields that were read.
    std::uint32_t learn_samples = 3;
    /// A field that was not read in this number of consecutive samples is no longer requested. 0: a field
    /// that was requested once is always requested.
    std::uint32_t narrow_after_samples = 100;
    /// True: samples from shared memory have only the fields that are requested at the time of take(), as
    /// they would on another host. So a program can be tested on one host before it runs on two hosts. For
    /// this purpose whole fields are copied; parts of fields are still read in place. The setting also
    /// applies to a subscriber whose fields are not recorded.
    bool as_remote = false;
  };

  TransportChoice transport = TransportChoice::automatic;  ///< the paths that samples may take
  /// A reliable subscriber matches reliable publishers only.
  Reliability reliability = Reliability::best_effort;
  /// transient_local: the subscriber requests the last samples from before it joined, and matches only
  /// publishers that retain samples.
  Durability durability = Durability::volatile_;
  /// The maximum number of samples of each publisher that are kept until they are taken, from 1 to
  /// 1,000,000. If more arrive, the oldest samples are lost and counted. Shared memory keeps at most 256
  /// samples. If a subscriber that may use shared memory requests more, this is logged, and
  /// SubscriberStatus::Writer::depth is the number in force. Of all departed publishers together, at most
  /// this number of samples is kept.
  std::uint32_t depth = 8;
  /// The maximum size in bytes of the samples of each publisher that are kept until they are taken; 0: only
  /// `depth` is a limit. If more bytes arrive, the oldest samples are lost, but the newest sample is always
  /// kept. So a subscriber that takes samples slowly, or not at all, cannot occupy all the memory that
  /// large samples of other subscribers need. In shared memory the number is rounded down to a power of two
  /// of at least 64 KiB.
  std::size_t depth_bytes = 32 * 1024 * 1024;
  std::chrono::nanoseconds deadline{0};  ///< the maximum time between two samples of a publisher
  /// A manual_by_topic subscriber matches only manual_by_topic publishers.
  Liveliness liveliness = Liveliness::automatic;
  /// The maximum time between two assertions that a publisher is alive.
  std::chrono::nanoseconds liveliness_lease{0};
  /// The maximum number of samples per second of each selection, evenly spaced, from slowest_rate_hz to
  /// fastest_rate_hz; 0: all samples. Further samples are withheld: they are not sent, and are counted
  /// separately from lost samples. Subscriber::set_max_rate_hz() changes the rate.
  double max_rate_hz = 0;
  /// The parts of the declared fields that are needed, the conditions under which a sample is needed, or
  /// both: "data{x,y,z}[::4]", "@ percentage > 20 or every 10 s" (TypeSupport::parse_selection()). Declared
  /// fields that the text does not name are sent completely. If fields are recorded, the text may have
  /// conditions only. If it is empty, whole fields of every sample are sent. Subscriber::set_selection()
  /// changes the selection. For a subscriber with sft::selected the text also names the fields:
  /// "header.stamp, data{x,y,z}"; if it names no field, all fields are requested. The option does not apply
  /// to subscribers whose type was not compiled into the program: the function that opens them takes such a
  /// text as an argument.
  std::string selection{};
  /// Further selections, as texts of the same kind: "pose.pose @ at most 100 Hz" as the first selection,
  /// and "pose.covariance @ at most 1 Hz" here. A message arrives once for each selection that lets it
  /// pass. SampleInfo::selection is the number of the sample's selection: 0 means the first selection, 1
  /// the first selection in this list. Of all samples that have arrived, the oldest is delivered first. The
  /// samples of one message are delivered in the order of the selections, if all have arrived. A sample may
  /// have more fields than its selection requests, since one encoding may serve several selections, and a
  /// sample in shared memory has all fields.
  ///
  /// For publishers and tools each selection is a separate subscriber, which matches and connects
  /// independently of the others. Publisher::wait_for_subscribers() and all limits count each selection.
  /// Each selection has its own status. `depth`, `max_held` and `max_rate_hz` apply to each selection;
  /// `deadline` applies only to the first selection. It is an error to give further selections if fields
  /// are recorded.
  std::vector<std::string> further_selections{};
  static constexpr std::size_t selections_max = 16;   ///< selections per subscriber, including the first one
  static constexpr double slowest_rate_hz = 0.001;    ///< the smallest max_rate_hz, apart from 0
  static constexpr double fastest_rate_hz = 100'000;  ///< the greatest max_rate_hz
  /// The minimum of max_held: one sample is held while the next one is taken.
  static constexpr std::uint32_t max_held_least = 2;
  /// The maximum of max_held, which is the limit of iceoryx.
  static constexpr std::uint32_t max_held_most = 256;
  /// The maximum number of samples in shared memory of one publisher that the program may hold at the same
  /// time. While it holds that number, take() returns no more samples of that publisher; the publisher's
  /// next samples stay in the queue, within `depth`. A sample with parts of fields holds the whole sample
  /// that contains them. Each time, the subscriber gets an event (Event::Kind::held_too_many). Other
  /// subscribers are not affected.
  std::uint32_t max_held = max_held_most;
  /// The time for which wait() spins, which keeps a core busy, before it sleeps. A sample that arrives
  /// within that time is taken within a microsecond, because no thread has to be woken. The default is
  /// about the time that it takes to wake a thread, so that spinning never costs more than it can save. A
  /// spinning thread yields the core to other threads that wait for it. If a wait ended without a sample,
  /// or took more than ten times this time, the next wait() sleeps at once. For a reader with a dedicated
  /// core, choose more than the period of the samples. For a subscriber with a callback, the thread that
  /// receives by UDP spins for this time (1 s at most), as long as the intervals between datagrams are
  /// about that short. The option has no effect on a subscriber that is pollable.
  std::chrono::nanoseconds spin = std::chrono::microseconds(20);
  /// True: the subscriber has a Subscriber::file_descriptor(), and its node has a thread that makes it
  /// readable for samples in shared memory. Must not be combined with a callback.
  bool pollable = false;
  Recording recording{};       ///< the settings for recorded fields
  Event::Callback on_event{};  ///< called with each event of the subscriber, on the node's thread for events
};

}  // namespace sft
