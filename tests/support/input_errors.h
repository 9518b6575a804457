#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

#include "leeway/robots/input_error.h"

namespace leeway::robots {

/// Expects a message that begins with FILE:LINE: (FILE: for line 0) and contains all of the words.
template <typename Call>
void expectInputError(const Call& call, const std::string& file, int line,
                      std::initializer_list<std::string> words) {
  try {
    call();
  } catch (const InputError& error) {
    const std::string message = error.what();
    const std::string begin = file + (line > 0 ? ":" + std::to_string(line) : "") + ": ";
    EXPECT_EQ(message.substr(0, begin.size()), begin) << message;
    EXPECT_EQ(error.file(), file);
    EXPECT_EQ(error.line(), line) << message;
    for (const std::string& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << "no \"" << word << "\" in: " << message;
    return;
  }
  FAIL() << "no InputError; expected one with \"" << (words.size() > 0 ? *words.begin() : "")
         << '"';
}

}  // namespace leeway::robots
