#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "../examples/support/plain_words.hpp"
#include "gelight/geodesic/dijkstra.hpp"
#include "gelight/geodesic/exact.hpp"
#include "gelight/geodesic/fast_marching.hpp"
#include "gelight/geodesic/heat.hpp"
#include "gelight/geodesic/virtual_source.hpp"
#include "gelight/mesh/repair.hpp"
#include "gelight/mesh/shapes.hpp"
#include "gelight/transport/vector_heat.hpp"
#include "support/spheres.hpp"
#include "support/timing.hpp"

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#if __has_include(<OpenMesh/Core/IO/MeshIO.hh>)
#include "../examples/support/mesh_file.hpp"
#define GELIGHT_READS_MESHES
#endif

// first_answer [MESH ...] [--json=FILE] [--commit=NAME]
//
// From a mesh to the first answer, and what each further one takes, for every solver: processor
// seconds, the median of nine further sources, none of them asked twice, since processors learn a
// query by heart. Peak memory is that of a process of its own, beyond the mesh. Errors are against
// the exact distances from one more source. MESH is a file that OpenMesh reads, or icosphere:LEVEL,
// noisy_sphere:LEVEL, membrane:MILLIMETRES (of an edge); `ordered:MESH` is ordered in space by
// `repair`, `shuffled:MESH` is in no order at all.

namespace {

using namespace gelight;

using Query = std::function<std::vector<double>(Index)>;

struct Method {
  std::string name;
  std::function<Query(const Mesh<double>&)> make;
  bool is_distance = true;
};

struct Figures {
  double first = 0, further = 0, megabytes = 0;
  double mean = 0, most = 0;  // relative errors
};

template <class Solver>
Method distances_by(const std::string& name) {
  return {name, [](const Mesh<double>& mesh) -> Query {
            const auto solver = std::make_shared<const Solver>(mesh);
            return [solver](Index source) { return solver->distance(source); };
          }};
}

template <class Answer>
Method vectors_by(const std::string& name, const Answer& answer) {
  return {name,
          [answer](const Mesh<double>& mesh) -> Query {
            const auto solver = std::make_shared<const VectorHeatSolver<double>>(mesh);
            return [solver, answer](Index source) {
              const auto vectors = answer(*solver, source);
              return std::vector<double>{vectors.back()[0]};
            };
          },
          false};
}

std::vector<Method> methods() {
  return {distances_by<DijkstraSolver<double>>("Dijkstra"),
          distances_by<FastMarchingSolver<double>>("fast marching"),
          distances_by<VirtualSourceSolver<double>>("virtual sources"),
          distances_by<ExactSolver<double>>("exact"),
          distances_by<HeatSolver<double>>("heat"),
          vectors_by("vector heat, transport",
                     [](const auto& solver, Index source) {
                       return solver.transport(source, solver.tangent_basis(source)[0]);
                     }),
          vectors_by("vector heat, log map",
                     [](const auto& solver, Index source) { return solver.log_map(source); })};
}

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// What `work` returns, in a process of its own, so that its memory is, too.
std::vector<double> in_own_process(const std::function<std::vector<double>()>& work) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("there is no pipe");
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("there is no process");
  if (child == 0) {
    close(ends[0]);
    std::FILE* const out = fdopen(ends[1], "wb");
    int status = 1;
    try {
      const auto numbers = work();
      status = std::fwrite(numbers.data(), sizeof(double), numbers.size(), out) != numbers.size();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
    }
    std::fclose(out);
    _exit(status);
  }
  close(ends[1]);
  std::FILE* const in = fdopen(ends[0], "rb");
  std::vector<double> numbers;
  for (double x = 0; std::fread(&x, sizeof x, 1, in) == 1;) numbers.push_back(x);
  std::fclose(in);
  int status = 0;
  waitpid(child, &status, 0);
  if (status != 0) throw std::runtime_error("a measurement failed");
  return numbers;
}

/// The k-th source: far from each other, none twice.
Index source_of(std::size_t k, const Mesh<double>& mesh) {
  constexpr std::size_t prime = 104729;
  return static_cast<Index>((k + 1) * prime % mesh.positions.size());
}

Figures measured(const Method& method, const Mesh<double>& mesh, const std::vector<double>& exact) {
  constexpr std::size_t further_queries = 9;
  const auto numbers = in_own_process([&]() -> std::vector<double> {
    const double before = peak_megabytes();
    double start = processor_seconds();
    const Query query = method.make(mesh);
    (void)query(source_of(1, mesh));
    const double first = processor_seconds() - start;
    std::vector<double> times;
    for (std::size_t k = 2; k < 2 + further_queries; ++k) {
      start = processor_seconds();
      (void)query(source_of(k, mesh));
      times.push_back(processor_seconds() - start);
    }
    const double megabytes = peak_megabytes() - before;
    double sum = 0, most = 0;
    std::size_t count = 0;
    const auto found = method.is_distance ? query(source_of(0, mesh)) : std::vector<double>{};
    for (std::size_t v = 0; v < found.size(); ++v) {
      if (!(exact[v] > 0) || !std::isfinite(exact[v])) continue;
      const double error = std::abs(found[v] / exact[v] - 1);
      sum += error;
      most = std::max(most, error);
      ++count;
    }
    const double mean = count > 0 ? sum / static_cast<double>(count) : 0;
    return {first, bench::median(times), megabytes, mean, most};
  });
  return {numbers.at(0), numbers.at(1), numbers.at(2), numbers.at(3), numbers.at(4)};
}

#if defined(GELIGHT_READS_MESHES)
Mesh<double> read(const std::string& file) { return mesh_of_file(file); }
#else
Mesh<double> read(const std::string& file) {
  throw std::runtime_error(file + " is not read: OpenMesh was not found");
}
#endif

/// Its vertices and faces in random order.
Mesh<double> shuffled(const Mesh<double>& mesh) {
  std::mt19937 random(1);
  std::vector<Index> order(mesh.positions.size()), now(order.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), random);
  Mesh<double> result;
  for (std::size_t v = 0; v < order.size(); ++v) {
    now[static_cast<std::size_t>(order[v])] = static_cast<Index>(v);
    result.positions.push_back(mesh.position(order[v]));
  }
  for (auto face : mesh.faces) {
    for (Index& v : face) v = now[static_cast<std::size_t>(v)];
    result.faces.push_back(face);
  }
  std::shuffle(result.faces.begin(), result.faces.end(), random);
  return result;
}

Mesh<double> mesh_of(const std::string& name) {
  const auto colon = name.find(':');
  const std::string shape = name.substr(0, colon);
  if (shape == "ordered") return repair(mesh_of(name.substr(8)), {.order_in_space = true}).mesh;
  if (shape == "shuffled") return shuffled(mesh_of(name.substr(9)));
  const double size = colon == std::string::npos ? 0 : std::atof(name.c_str() + colon + 1);
  if (shape == "icosphere") return icosphere<double>(static_cast<Index>(size));
  if (shape == "noisy_sphere") return bench::noisy_sphere(static_cast<int>(size));
  if (shape == "membrane") return membrane<double>(0.01146, 0.0455, 1e-3 * size);
  return read(name);
}

struct Row {
  std::string mesh, method;
  std::size_t vertices;
  Figures figures;
};

std::vector<Row> rows_of(const std::string& name) {
  const Mesh<double> mesh = mesh_of(name);
#if defined(__GLIBC__)
  malloc_trim(0);  // what a reader of files gave back would hide what solvers take
#endif
  std::printf("\n%s, %zu vertices\n\n", name.c_str(), mesh.positions.size());
  std::printf(
      "| | first answer, s | further, ms | peak, MB | mean error | largest |\n"
      "|---|---|---|---|---|---|\n");
  const auto exact =
      in_own_process([&] { return ExactSolver<double>(mesh).distance(source_of(0, mesh)); });
  std::vector<Row> rows;
  for (const Method& method : methods()) {
    const Figures f = measured(method, mesh, exact);
    std::printf("| %s | %.3f | %.2f | %.0f | ", method.name.c_str(), f.first, 1e3 * f.further,
                f.megabytes);
    if (method.is_distance) {
      std::printf("%.2g %% | %.2g %% |\n", 100 * f.mean, 100 * f.most);
    } else {
      std::printf("| |\n");
    }
    rows.push_back({name, method.name, mesh.positions.size(), f});
  }
  return rows;
}

void write_json(const std::string& file, const std::string& commit, const std::vector<Row>& rows) {
  std::ofstream out(file);
  out << R"({"commit": ")" << commit << R"(", "flags": ")" << GELIGHT_FLAGS << R"(", "rows": [)";
  const char* comma = "\n";
  for (const Row& row : rows) {
    const Figures& f = row.figures;
    out << comma << R"(  {"mesh": ")" << row.mesh << R"(", "method": ")" << row.method
        << R"(", "vertices": )" << row.vertices << R"(, "first_s": )" << f.first
        << R"(, "further_s": )" << f.further << R"(, "peak_MB": )" << f.megabytes << R"(, "mean": )"
        << f.mean << R"(, "max": )" << f.most << "}";
    comma = ",\n";
  }
  out << "\n]}\n";
  if (!out.flush()) throw std::runtime_error(file + " cannot be written");
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string usage = "usage: first_answer [MESH ...] [--json=FILE] [--commit=NAME]";
  std::vector<std::string> meshes;
  std::string json, commit = "unknown";
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.starts_with("--json=")) {
      json = argument.substr(7);
    } else if (argument.starts_with("--commit=")) {
      commit = argument.substr(9);
    } else if (argument.starts_with("-")) {
      if (argument == "--help" || argument == "-h") throw HelpAsked{usage};
      throw std::runtime_error("what is " + argument + "? " + usage);
    } else {
      meshes.push_back(argument);
    }
  }
  if (meshes.empty()) meshes = {"membrane:0.4", "noisy_sphere:6", "icosphere:6"};
  if (!json.empty()) require_writable(json);
  std::vector<Row> rows;
  for (const std::string& mesh : meshes) {
    for (Row& row : rows_of(mesh)) rows.push_back(std::move(row));
  }
  if (!json.empty()) write_json(json, commit, rows);
  return 0;
} catch (...) {
  return told();
}
