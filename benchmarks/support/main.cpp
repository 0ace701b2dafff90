#include "run.hpp"

// Of the benchmarks that have no main of their own.
int main(int argc, char** argv) { return gelight::bench::run(argc, argv); }
