#include "command_line.hpp"

#include <CLI/CLI.hpp>
#include <stdexcept>

struct CommandLine::Parser {
  CLI::App app;
};

CommandLine::CommandLine(const std::string& what_the_program_does, const std::string& program)
    : parser_(new Parser{CLI::App(what_the_program_does, program)}) {}

CommandLine::~CommandLine() = default;

void CommandLine::add(const std::string& name, double& value, const std::string& help) {
  parser_->app.add_option(name, value, help)->capture_default_str();
}

void CommandLine::add(const std::string& name, int& value, const std::string& help) {
  parser_->app.add_option(name, value, help)->capture_default_str();
}

void CommandLine::add(const std::string& name, std::string& value, const std::string& help) {
  CLI::Option* const option = parser_->app.add_option(name, value, help);
  if (!value.empty()) option->capture_default_str();
}

void CommandLine::add(const std::string& name, std::vector<std::string>& values,
                      const std::string& help) {
  parser_->app.add_option(name, values, help);
}

void CommandLine::add(const std::string& name, std::optional<double>& value,
                      const std::string& help) {
  parser_->app.add_option(name, value, help);
}

void CommandLine::add_within(const std::string& name, double& value, double least, double most,
                             const std::string& help) {
  add(name, value, help);
  parser_->app.get_option(name)->check(CLI::Range(least, most));
}

void CommandLine::add_within(const std::string& name, int& value, int least, int most,
                             const std::string& help) {
  add(name, value, help);
  parser_->app.get_option(name)->check(CLI::Range(least, most));
}

void CommandLine::add_within(const std::string& name, std::optional<int>& value, int least,
                             int most, const std::string& help) {
  parser_->app.add_option(name, value, help)->check(CLI::Range(least, most));
}

void CommandLine::add_one_of(const std::string& name, std::string& value,
                             const std::vector<std::string>& choices, const std::string& help) {
  add(name, value, help);
  parser_->app.get_option(name)->check(CLI::IsMember(choices));
}

void CommandLine::add_required(const std::string& name, std::string& value,
                               const std::string& help) {
  parser_->app.add_option(name, value, help)->required();
}

void CommandLine::read(int count, char** arguments) {
  try {
    parser_->app.parse(count, arguments);
  } catch (const CLI::Success&) {
    throw HelpAsked{parser_->app.help()};
  } catch (const CLI::ParseError& wrong) {
    throw std::runtime_error(wrong.what());
  }
}

bool CommandLine::has(const std::string& name) const { return parser_->app.count(name) > 0; }

std::string CommandLine::program() const { return parser_->app.get_name(); }
