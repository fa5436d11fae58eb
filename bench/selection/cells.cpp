#include "sft/cells.h"

#include <array>
#include <cstdlib>
#include <optional>
#include <sensor_msgs/msg/Image.hpp>
#include <string>
#include <vector>

#include "bench/common/contest.h"
#include "bench/common/process.h"
#include "bench/selection/local_part.h"
#include "bench/selection/selection.h"
#include "bench/typesupport/messages.h"

namespace sft::bench {

namespace {

using namespace detail;
using sensor_msgs::msg::Image;
using ImageView = ViewOf<Image, all<Image>>;
using Rgb = std::array<std::uint8_t, 3>;
using ColourSums = std::array<std::uint32_t, 3>;

/// A range of rows and columns of an image.
struct Window {
  std::uint32_t first_row, rows, first_column, columns;
};
constexpr Window all_pixels{0, 1080, 0, 1920};
constexpr Window middle{270, 540, 480, 960};
constexpr const char* text_of_middle = "data[rows 270:810, columns 480:1440]";

Image coloured_image() {
  Image image;
  image.height = all_pixels.rows;
  image.width = all_pixels.columns;
  image.encoding = "rgb8";
  image.step = 3 * image.width;
  image.data.resize(std::size_t{image.height} * image.step);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<std::uint8_t>(i * 7 % 251);
  return image;
}

/// The loop of a program that knows the position of the window.
[[gnu::noinline]] ColourSums colours_by_hand(const ImageView& view, const Window& window) {
  const std::uint8_t* const data = view.data().data();
  const std::size_t step = view.step();
  ColourSums sums{};
  for (std::size_t row = window.first_row; row < window.first_row + window.rows; ++row) {
    const std::uint8_t* pixel = data + row * step + 3 * window.first_column;
    for (std::size_t left = window.columns; left > 0; --left, pixel += 3) {
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += pixel[i];
    }
  }
  return sums;
}

[[gnu::noinline]] ColourSums colours_of_cells(const ImageView& view) {
  ColourSums sums{};
  const auto pixels = view.data<Rgb>();
  if (!pixels) return sums;
  for (const auto [red, green, blue] : *pixels) {
    sums[0] += red;
    sums[1] += green;
    sums[2] += blue;
  }
  return sums;
}

[[gnu::noinline]] ColourSums colours_of_rows(const ImageView& view) {
  ColourSums sums{};
  const auto pixels = view.data<Rgb>();
  if (!pixels) return sums;
  for (std::size_t row = 0; row < pixels->rows(); ++row) {
    const auto cells = pixels->row(row);
    if (!cells) return {};
    for (const Rgb& pixel : *cells) {
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += pixel[i];
    }
  }
  return sums;
}

using Loop = ColourSums (*)(const ImageView&);

Figure time_of_pixels(std::string name, Loop loop, const ImageView& view, const ImageView& whole,
                      const Window& window, std::optional<double> bound, int rounds) {
  if (loop(view) != colours_by_hand(whole, window)) std::abort();
  const auto best = best_times_ns(
      {batch_of([&] { keep(loop(view)); }), batch_of([&] { keep(colours_by_hand(whole, window)); })}, rounds);
  return {
      std::move(name), best[0] / 1000, "us", best[1] / 1000, "a loop by hand that sums the colours", bound};
}

}  // namespace

std::vector<Figure> reading_cells(int rounds) {
  pin_to_core(1);
  const Sample whole(coloured_image());
  const LocalPart part(type_support<Image>(), whole, text_of_middle);
  const ImageView full = view_of<Image, all<Image>>(whole.state());
  const ImageView window = view_of<Image, all<Image>>(part.state());
  // There is no bound, because the loop by hand is vectorised, and a loop that checks for the ends of rows
  // is not.
  constexpr std::optional<double> none;
  return {time_of_pixels("cells_rows_full", colours_of_rows, full, full, all_pixels, 1.1, rounds),
          time_of_pixels("cells_rows_in_place", colours_of_rows, window, full, middle, 1.1, rounds),
          time_of_pixels("cells_each_full", colours_of_cells, full, full, all_pixels, none, rounds),
          time_of_pixels("cells_each_in_place", colours_of_cells, window, full, middle, none, rounds)};
}

}  // namespace sft::bench
