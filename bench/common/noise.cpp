#include "bench/common/noise.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace sft::bench {

namespace {

double seconds_of(int who) {
  rusage usage{};
  getrusage(who, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

Noise::Moment Noise::now() {
  std::ifstream stat("/proc/stat");
  std::string name;
  double user = 0, nice = 0, system = 0, idle = 0, waiting = 0, interrupts = 0, soft_interrupts = 0,
         stolen = 0;
  stat >> name >> user >> nice >> system >> idle >> waiting >> interrupts >> soft_interrupts >> stolen;
  const auto tick_s = 1 / static_cast<double>(sysconf(_SC_CLK_TCK));
  const double busy = user + nice + system + interrupts + soft_interrupts;
  return {.busy_s = busy * tick_s,
          .stolen_s = stolen * tick_s,
          .all_s = (busy + idle + waiting + stolen) * tick_s,
          .own_s = seconds_of(RUSAGE_SELF) + seconds_of(RUSAGE_CHILDREN)};
}

Noise::Shares Noise::shares() const {
  const Moment end = now();
  const double all = end.all_s - begin_.all_s, own = end.own_s - begin_.own_s;
  // A time of zero ticks has no shares.
  const auto percent = [&](double seconds) { return all > 0 ? 100 * std::max(0., seconds) / all : 0; };
  return {.own = percent(own),
          .other_programs = percent(end.busy_s - begin_.busy_s - own),
          .other_machines = percent(end.stolen_s - begin_.stolen_s)};
}

std::string text_of(const Noise::Shares& shares) {
  return fmt::format(
      "Noise: beside the {:.0f} % that this benchmark took of the processors, other programs and interrupts "
      "took {:.1f} %, and other virtual machines {:.1f} %.",
      shares.own, shares.other_programs, shares.other_machines);
}

std::vector<Figure> figures_of(const Noise::Shares& shares) {
  return {{.name = "noise_other_programs", .value = shares.other_programs, .unit = "%"},
          {.name = "noise_other_machines", .value = shares.other_machines, .unit = "%"}};
}

}  // namespace sft::bench
