// The light of a blackbody: Stefan and Boltzmann's brightness in the colour of Planck's law.
#include "shared/blackbody.h"
