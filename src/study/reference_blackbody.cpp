#include "study/reference_blackbody.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace fumarole::study {

namespace {

/// The colour-matching functions of the CIE 1931 standard observer, 2 degrees, 380 nm to 780 nm in
/// steps of 5 nm (CIE 15: Colorimetry).
constexpr double kFirst = 380, kStep = 5;  // nm
constexpr std::array<std::array<double, 3>, 81> kObserver{{
    {0.001368, 3.9e-05, 0.00645}, {0.002236, 6.4e-05, 0.01055}, {0.004243, 0.00012, 0.02005},
    {0.00765, 0.000217, 0.03621}, {0.01431, 0.000396, 0.06785}, {0.02319, 0.00064, 0.1102},
    {0.04351, 0.00121, 0.2074},   {0.07763, 0.00218, 0.3713},   {0.13438, 0.004, 0.6456},
    {0.21477, 0.0073, 1.03905},   {0.2839, 0.0116, 1.3856},     {0.3285, 0.01684, 1.62296},
    {0.34828, 0.023, 1.74706},    {0.34806, 0.0298, 1.7826},    {0.3362, 0.038, 1.77211},
    {0.3187, 0.048, 1.7441},      {0.2908, 0.06, 1.6692},       {0.2511, 0.0739, 1.5281},
    {0.19536, 0.09098, 1.28764},  {0.1421, 0.1126, 1.0419},     {0.09564, 0.13902, 0.81295},
    {0.05795, 0.1693, 0.6162},    {0.03201, 0.20802, 0.46518},  {0.0147, 0.2586, 0.3533},
    {0.0049, 0.323, 0.272},       {0.0024, 0.4073, 0.2123},     {0.0093, 0.503, 0.1582},
    {0.0291, 0.6082, 0.1117},     {0.06327, 0.71, 0.07825},     {0.1096, 0.7932, 0.05725},
    {0.1655, 0.862, 0.04216},     {0.22575, 0.91485, 0.02984},  {0.2904, 0.954, 0.0203},
    {0.3597, 0.9803, 0.0134},     {0.43345, 0.99495, 0.00875},  {0.51205, 1, 0.00575},
    {0.5945, 0.995, 0.0039},      {0.6784, 0.9786, 0.00275},    {0.7621, 0.952, 0.0021},
    {0.8425, 0.9154, 0.0018},     {0.9163, 0.87, 0.00165},      {0.9786, 0.8163, 0.0014},
    {1.0263, 0.757, 0.0011},      {1.0567, 0.6949, 0.001},      {1.0622, 0.631, 0.0008},
    {1.0456, 0.5668, 0.0006},     {1.0026, 0.503, 0.00034},     {0.9384, 0.4412, 0.00024},
    {0.85445, 0.381, 0.00019},    {0.7514, 0.321, 0.0001},      {0.6424, 0.265, 5e-05},
    {0.5419, 0.217, 3e-05},       {0.4479, 0.175, 2e-05},       {0.3608, 0.1382, 1e-05},
    {0.2835, 0.107, 0},           {0.2187, 0.0816, 0},          {0.1649, 0.061, 0},
    {0.1212, 0.04458, 0},         {0.0874, 0.032, 0},           {0.0636, 0.0232, 0},
    {0.04677, 0.017, 0},          {0.0329, 0.01192, 0},         {0.0227, 0.00821, 0},
    {0.01584, 0.005723, 0},       {0.011359, 0.004102, 0},      {0.008111, 0.002929, 0},
    {0.00579, 0.002091, 0},       {0.004109, 0.001484, 0},      {0.002899, 0.001047, 0},
    {0.002049, 0.00074, 0},       {0.00144, 0.00052, 0},        {0.001, 0.000361, 0},
    {0.00069, 0.000249, 0},       {0.000476, 0.000172, 0},      {0.000332, 0.00012, 0},
    {0.000235, 8.5e-05, 0},       {0.000166, 6e-05, 0},         {0.000117, 4.2e-05, 0},
    {8.3e-05, 3e-05, 0},          {5.9e-05, 2.1e-05, 0},        {4.2e-05, 1.5e-05, 0},
}};

constexpr double kSecondRadiation = 1.438776877e-2;  // h c / k, CODATA 2018 [m K]
constexpr double kStefanBoltzmann = 5.670374419e-8;  // CODATA 2018 [W/m^2/K^4]

constexpr double kColdestColor = 800, kHottest = 40000;  // K
constexpr double kDark = 500, kDraper = 798;             // K

/// Colours at inverse temperatures that are evenly spaced, with a cubic between them: 1e-9 of
/// what a sum over the observer gives at once, and a hundred times as fast.
class ColorTable {
public:
    ColorTable()
    {
        for (int i = -1; i <= kIntervals + 1; ++i)
            colors_.push_back(rec709_from_xyz(planck_xyz(1 / (kLeast + i * kApart))));
    }

    [[nodiscard]] glm::dvec3 at(double kelvin) const
    {
        const double x = (1 / std::clamp(kelvin, kColdestColor, kHottest) - kLeast) / kApart;
        const double cell = std::clamp(std::floor(x), 0.0, kIntervals - 1.0), u = x - cell;
        const glm::dvec3* c = &colors_[static_cast<std::size_t>(cell)];
        // Lagrange's through four.
        const double a = -u * (u - 1) * (u - 2) / 6, b = (u + 1) * (u - 1) * (u - 2) / 2,
                     d = -(u + 1) * u * (u - 2) / 2, e = (u + 1) * u * (u - 1) / 6;
        return a * c[0] + b * c[1] + d * c[2] + e * c[3];
    }

private:
    static constexpr int kIntervals = 1000;
    static constexpr double kLeast = 1 / kHottest,
                            kApart = (1 / kColdestColor - 1 / kHottest) / kIntervals;
    std::vector<glm::dvec3> colors_;
};

}  // namespace

glm::dvec3 planck_xyz(double kelvin)
{
    // Only ratios count, and exp would leave the range of numbers where it is cold.
    const double green = kSecondRadiation / (560e-9 * kelvin);
    glm::dvec3 xyz(0);
    for (std::size_t i = 0; i < kObserver.size(); ++i) {
        const double metres = 1e-9 * (kFirst + kStep * static_cast<double>(i));
        const double x = kSecondRadiation / (metres * kelvin);
        const double radiance = std::pow(560e-9 / metres, 5) * std::exp(green - x) *
                                std::expm1(-green) / std::expm1(-x);
        xyz += radiance * glm::dvec3(kObserver[i][0], kObserver[i][1], kObserver[i][2]);
    }
    return xyz / xyz.y;
}

glm::dvec3 rec709_from_xyz(glm::dvec3 xyz)
{
    const auto from_xy = [](double x, double y) { return glm::dvec3(x / y, 1, (1 - x - y) / y); };
    static const glm::dmat3 from_rgb = [&] {
        const glm::dmat3 primaries(from_xy(0.64, 0.33), from_xy(0.3, 0.6), from_xy(0.15, 0.06));
        const glm::dvec3 of_white = glm::inverse(primaries) * from_xy(0.3127, 0.329);
        return glm::dmat3(primaries[0] * of_white[0], primaries[1] * of_white[1],
                          primaries[2] * of_white[2]);
    }();
    return glm::inverse(from_rgb) * xyz;
}

glm::dvec3 blackbody_color(double kelvin)
{
    static const ColorTable table;
    return glm::max(table.at(kelvin), glm::dvec3(0));
}

glm::dvec3 blackbody_emission(double kelvin)
{
    if (!(kelvin > kDark))
        return glm::dvec3(0);
    const double t = std::min(kelvin, kHottest), u = std::min((t - kDark) / (kDraper - kDark), 1.0);
    const double in_full = kStefanBoltzmann * t * t * t * t / std::numbers::pi;
    constexpr double kMegawatt = 1e6;
    return in_full / kMegawatt * u * u * (3 - 2 * u) * blackbody_color(t);
}

}  // namespace fumarole::study
