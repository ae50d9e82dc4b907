#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace fumarole::study {

/// A text in single quotes, printable and cut to 200 bytes, as gnuplot takes it.
std::string in_quotes(std::string_view text);

/// `$name << EOD`, the rows, `EOD`.
std::string data_block(const std::string& name, const std::string& rows);

/// Runs a program for gnuplot, which names its own outputs; `folder` holds it for a moment.
/// @throws Error if gnuplot is not there or fails.
void run_gnuplot(const std::string& program, const std::filesystem::path& folder);

}  // namespace fumarole::study
