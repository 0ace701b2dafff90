#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plain_words.hpp"

/// What a program takes from its command line. CLI11 reads it, in a source of its own, for that
/// takes longer to compile than most programs.
///
/// An argument's name is a word, an option's begins with two dashes. Values are what stands on the
/// command line, and else stay what they were, which --help says of numbers and of words.
class CommandLine {
 public:
  explicit CommandLine(const std::string& what_the_program_does, const std::string& program = {});
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  void add(const std::string& name, double& value, const std::string& help);
  void add(const std::string& name, int& value, const std::string& help);
  void add(const std::string& name, std::string& value, const std::string& help);
  void add(const std::string& name, std::vector<std::string>& values, const std::string& help);
  void add(const std::string& name, std::optional<double>& value, const std::string& help);

  /// Of which only some values are taken.
  ///@{
  void add_within(const std::string& name, double& value, double least, double most,
                  const std::string& help);
  void add_within(const std::string& name, int& value, int least, int most,
                  const std::string& help);
  void add_within(const std::string& name, std::optional<int>& value, int least, int most,
                  const std::string& help);
  void add_one_of(const std::string& name, std::string& value,
                  const std::vector<std::string>& choices, const std::string& help);
  ///@}

  /// Without which the program does not run.
  void add_required(const std::string& name, std::string& value, const std::string& help);

  /// Throws HelpAsked for --help, and std::runtime_error, which says what is wrong.
  void read(int count, char** arguments);

  /// Whether an option stood on the command line that was read.
  [[nodiscard]] bool has(const std::string& name) const;
  [[nodiscard]] std::string program() const;

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};
