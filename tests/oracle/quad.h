#pragma once

#include "oracle/quad.h"
