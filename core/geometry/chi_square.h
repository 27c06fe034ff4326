#pragma once

namespace rigcal {

// Of the chi-square distribution: what such a share of its values, in percent, does not exceed, by its degrees of
// freedom.
inline constexpr double chi2_50_1 = 0.455;
inline constexpr double chi2_95_3 = 7.815;
inline constexpr double chi2_68_6 = 7.0058;
inline constexpr double chi2_95_6 = 12.592;
inline constexpr double chi2_999_6 = 22.46;  ///< Of 1000, not of 100.

}  // namespace rigcal
