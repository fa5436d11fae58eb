// Must compile: correct uses of what the other snippets misuse.
#include "tests/compile_fail/cloud.h"

std::uint32_t width(sft::Subscriber<PointCloud2, F::width | F::header.stamp>& subscriber) {
  const auto sample = subscriber.take();
  return sample->width() + sample->header().stamp().nanosec() + sample.view().width();
}

std::uint32_t counts(const sft::Sample<PointCloud2, F::fields.each.count>& sample) {
  std::uint32_t sum = 0;
  for (const auto field : sample->fields()) sum += field.count();
  return sum;
}

std::size_t width_as_recorded(const sft::Sample<PointCloud2, sft::recorded>& sample) {
  return sample->width().value_or(0) + sample.to_partial().value().value.width + sample.cdr().size();
}

std::size_t name_bytes(const sft::Sample<PointCloud2, F::header>& sample) {
  return sample->header().frame_id().size();
}

bool has_points(const sft::Sample<PointCloud2, ~(F::header | F::is_dense)>& sample) {
  return sample->points<float>("x").has_value();
}

std::size_t part_of_the_data(
    const sft::Sample<PointCloud2, F::width | F::data.channels<"x", "z">.every(4)>& sample) {
  return sample->points<float, float>("x", "z").value().size() + sample->data().size() + sample->width();
}

constexpr sft::Mask<Image> pixels = ~Image::Field::header;
std::size_t pixels_of(
    const sft::Sample<Image, pixels>& all, const sft::Sample<Image, Image::Field::data.rows(0, 10)>& part,
    const sft::Sample<sensor_msgs::msg::LaserScan, sensor_msgs::msg::LaserScan::Field::ranges>& scan) {
  return all->data<std::uint8_t>().value().size() + part->data<std::uint8_t>().value().size() +
         scan->ranges<float>().value().size();
}

struct Stamp {
  std::int32_t sec;
  std::uint32_t nanosec;
};
struct HeaderOfProgram {
  Stamp stamp;
  std::string frame_id;
};
auto pass_on(const sft::Sample<std_msgs::msg::Header>& sample,
             sft::Publisher<std_msgs::msg::Header>& publisher) {
  HeaderOfProgram header{};
  (void)sample.fill(header);
  return publisher.publish(header);
}
auto recorded_header(const sft::Sample<std_msgs::msg::Header, sft::recorded>& sample,
                     HeaderOfProgram& header) {
  return sample.fill(header).has_value() && sample.fill_partial(header).has_value();
}

PointCloud2 owned(const sft::Sample<PointCloud2>& sample) { return sample.to_owned().value(); }

auto subscribe(sft::Node& node) {
  return node.subscriber<PointCloud2, F::header.stamp | F::height>("points");
}

auto subscribe_with_callbacks(sft::Node& node) {
  using Sample = sft::Sample<PointCloud2, F::height>;
  return std::tuple(
      node.subscriber<PointCloud2, F::height>("points", [](const auto& sample) { (void)sample->height(); }),
      node.subscriber<PointCloud2, F::height>("points", [](const Sample& sample) { (void)sample->height(); }),
      node.subscriber<PointCloud2, F::height>("points", [](Sample) {}, {.depth = 2}));
}

auto subscribe_with_options(sft::Node& node, const sft::SubscriberOptions& options) {
  return node.subscriber<PointCloud2, F::height>("points", options);
}

sft::PublishStatus fill(sft::Publisher<PointCloud2>& publisher) {
  auto loan = publisher.loan(PointCloud2{}, {.data = 8}).value();
  loan->data()[0] = 1;
  loan.set(F::width, 1024);
  loan.set(F::header.stamp.sec, 1);
  loan.shrink(F::data, 4);
  return std::move(loan).publish();
}

std::string_view second_name(const sft::Sample<PointCloud2, F::fields>& sample) {
  return sample->fields()[1].name();
}

static_assert((F::header & F::header.stamp) == F::header.stamp && F::height != F::width);
