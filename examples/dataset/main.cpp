// Images by the million, from one description:
//
//     scene.json --> parts of the samples --> rank 0: its threads --.
//                    dealt one by one    \--> rank 1: its threads --+-> out.h5.parts/*.h5 -->
//                    out.h5
//                                         \-> ...                 --'
//
// dataset scene.json out.h5, or mpirun -n 8 dataset scene.json out.h5. Sample i is the same, bit
// for bit, for any number of ranks and threads. Killed at any moment and started again, it goes on.

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "../support/figure.hpp"
#include "../support/parted_work.hpp"
#include "columns.hpp"

namespace {

struct Settings {
  std::string description, out;
  int threads = 0;
};

/// The sensors of a scene, and the samplers and clocks of each thread.
struct Workshop {
  const Scene& scene;
  LitSensors sensors;
  std::vector<Sampler> samplers;
  std::vector<Stopwatch> watches;

  Workshop(const Scene& of, int threads)
      : scene(of), sensors(of), watches(static_cast<std::size_t>(threads)) {
    for (int t = 0; t < threads; ++t) samplers.emplace_back(scene, sensors);
  }

  void make_part(const PartedFile& file, int number, int thread) {
    Sampler& sampler = samplers[static_cast<std::size_t>(thread)];
    Stopwatch& watch = watches[static_cast<std::size_t>(thread)];
    Part part = file.new_part(number);
    for (std::uint64_t row = 0; row < file.rows_of(number); ++row) {
      const Sample& sample = sampler.sample(file.first_row(number) + row, watch);
      put_sample(part, file.columns(), row, sample);
      watch.lap(Stage::compress);
    }
    file.write(number, part);
    watch.lap(Stage::write);
  }

  [[nodiscard]] std::vector<double> times() const {
    std::vector<double> sum(static_cast<std::size_t>(Stage::count));
    for (const Stopwatch& watch : watches) {
      for (std::size_t s = 0; s < sum.size(); ++s) sum[s] += watch.times()[s];
    }
    return sum;
  }
};

/// Samples picked at random, a hundred where there are as many, ten a row.
void draw_contact_sheet(const std::string& out, const Scene& scene) {
  const auto guard = hdf5::lock();
  const hdf5::ReadFile file(out);
  const std::uint64_t count = std::min<std::uint64_t>(100, scene.samples);
  const int columns = 10, rows = static_cast<int>((count + 9) / 10), gap = 4;
  const double scale = 160.0 / std::max(scene.width, scene.height);
  const double width = scale * scene.width, height = scale * scene.height;
  Figure figure(static_cast<int>(columns * (width + gap)) + gap,
                static_cast<int>(rows * (height + gap)) + gap);
  for (std::uint64_t i = 0; i < count; ++i) {
    // One of each hundredth of the samples, whole samples, so that none is there twice.
    const double u = gelight::detail::uniforms(scene.seed, i, 0xFFFFFFFF)[0];
    const std::uint64_t from = i * scene.samples / count, to = (i + 1) * scene.samples / count;
    const auto row = from + static_cast<std::uint64_t>(u * static_cast<double>(to - from));
    const auto levels = file.row<std::uint8_t>("image", row);
    Image<gelight::Rgb8> image(scene.width, scene.height);
    for (std::size_t p = 0; p < image.pixels().size(); ++p) {
      image.pixels()[p] = {levels[3 * p], levels[3 * p + 1], levels[3 * p + 2]};
    }
    figure.image(image, gap + static_cast<double>(i % 10) * (width + gap),
                 gap + static_cast<double>(i / 10) * (height + gap), scale);
  }
  write_durably(out + ".png", std::as_bytes(std::span<const char>(figure.png())));
}

void print_summary(const PartedFile& file, const std::vector<double>& times, double samples,
                   double seconds, double memory) {
  const char* const names[] = {"sensors", "objects", "render", "labels", "compress", "write"};
  double all = 0;
  for (const double time : times) all += time;
  std::printf("%.0f samples in %s: %.3g a second, %.3g a second of processor time\n", samples,
              ProgressLine::time(seconds).c_str(), samples / seconds, samples / all);
  for (std::size_t s = 0; s < times.size(); ++s) {
    std::printf("  %-9s %5.1f %%  %8.3f ms a sample\n", names[s], 100 * times[s] / all,
                1e3 * times[s] / samples);
  }
  std::printf("%.1f kB a sample, %.0f MB in all; %.0f MB of memory a rank at most\n",
              1e-3 * static_cast<double>(file.bytes()) / static_cast<double>(file.rows()),
              1e-6 * static_cast<double>(file.bytes()), memory);
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void run(const Ranks& ranks, const Settings& settings) {
  const Scene scene = read_scene(settings.description);
  Workshop workshop(scene, settings.threads);
  PartedFile file(settings.out, scene.sample_text, columns_of(scene), scene.samples, scene.part);
  const auto start = std::chrono::steady_clock::now();
  const std::vector<int> made =
      make_missing_parts(ranks, file, settings.threads, "samples",
                         [&](int number, int thread) { workshop.make_part(file, number, thread); });
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  const auto times = ranks.sum(workshop.times());
  const double memory = ranks.largest(peak_megabytes());
  if (!ranks.is_first()) return;
  file.finish(notes_of(scene));
  if (scene.store.image) draw_contact_sheet(settings.out, scene);
  if (made.empty()) return;
  double samples = 0;
  for (const int number : made) samples += static_cast<double>(file.rows_of(number));
  print_summary(file, times, samples, passed.count(), memory);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CommandLine line("Renders the samples that a description asks for into an HDF5 file.", "dataset");
  line.add_required("description", settings.description, "scene.json");
  line.add_required("out", settings.out, "the HDF5 file; its parts go beside it");
  hdf5::be_quiet();
  return run_on_ranks(argc, argv, line, settings.threads,
                      [&](const Ranks& ranks) { run(ranks, settings); });
}
