// rankedEngines() makes engines that divide their directions among all ranks. Counts are integers, so that their sums
// have the same bits as the counts of one rank.
#pragma once
#include <string>

#include <viewpeel/engine.h>
#include "engines/lattice_options.h"
#include "ranks/crew.h"
#include "ranks/message.h"

namespace viewpeel {

// Returns a factory whose engines count on all ranks.
//   In: crew: kept by the caller; make_engine: for the part of this rank; kind: of the engines of other ranks
EngineFactory rankedEngines(Crew& crew, EngineFactory make_engine, EngineKind kind);

// Returns the question that opens an engine on another rank, and the words that close it.
//   In: number: Crew::newNumber()
std::string openingOf(uint64_t number, EngineKind kind, const LatticeOptions& options, const Ids& ids);
std::string closingOf(uint64_t number);

// These write and read the options that change counts, and the size of batches, as a part of a message between ranks.
void putLattice(MessageWriter& out, const LatticeOptions& options);
LatticeOptions getLattice(MessageReader& in);

}  // namespace viewpeel
